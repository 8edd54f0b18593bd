(define (problem morning)
    (:domain coffee)
    (:objects
        WaterCup CoffeeGrinds - vessel
        CoffeeMachine - machine
        counter - surface)
    (:init
        (hand-empty)
        (at WaterCup counter) (full WaterCup) (holds-water WaterCup)
        (at CoffeeGrinds counter) (full CoffeeGrinds) (holds-grounds CoffeeGrinds)
        (lid-open CoffeeMachine))
    (:goal (and
        (brewed CoffeeMachine) (at WaterCup counter) (at CoffeeGrinds counter))))
