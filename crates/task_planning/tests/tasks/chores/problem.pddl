(define (problem household)
    (:domain chores)
    (:objects
        bottle wrapper mug - item
        bin - bin
        hall-light kitchen-light - switch
        sink - faucet
        cabinet - drawer
        table counter - surface)
    (:init
        (hand-empty)
        (on bottle table) (rubbish bottle)
        (in wrapper cabinet) (rubbish wrapper)
        (on mug counter)
        (lit hall-light) (running sink)
        (= (total-cost) 0)
        (= (effort bottle) 1.5) (= (effort wrapper) 1) (= (effort mug) 1))
    (:goal (and (tidy) (not (lit hall-light)) (not (running sink)) (on mug table)))
    (:metric minimize (total-cost)))
