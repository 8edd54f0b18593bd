; The three chores of dissertation 6.3.1 as one domain: throw an item away, turn a light off, close a
; faucet. Written for Factotum.
(define (domain chores)
    (:requirements :strips :typing :equality :negative-preconditions
        :universal-preconditions :existential-preconditions :conditional-effects :action-costs)
    (:types
        thing place - object
        item fixture - thing
        bin switch faucet drawer - fixture
        surface - place)
    (:constants gripper - place)
    (:predicates
        (on ?i - item ?p - place)
        (in ?i - item ?f - fixture)
        (rubbish ?i - item)
        (hand-empty)
        (lit ?s - switch)
        (running ?f - faucet)
        (open ?d - drawer)
        (tidy))
    (:functions
        (total-cost) - number
        (effort ?i - item) - number)

    (:action pick
        :parameters (?i - item ?p - surface)
        :precondition (and (hand-empty) (on ?i ?p))
        :effect (and
            (on ?i gripper) (not (on ?i ?p)) (not (hand-empty))
            (increase (total-cost) (effort ?i))))

    (:action take-out
        :parameters (?i - item ?d - drawer)
        :precondition (and (hand-empty) (in ?i ?d) (open ?d))
        :effect (and
            (on ?i gripper) (not (in ?i ?d)) (not (hand-empty))
            (increase (total-cost) (effort ?i))))

    (:action place
        :parameters (?i - item ?p - place)
        :precondition (and (on ?i gripper) (not (= ?p gripper)))
        :effect (and
            (on ?i ?p) (hand-empty) (not (on ?i gripper)) (increase (total-cost) 1)))

    (:action throw-away
        :parameters (?i - item ?b - bin)
        :precondition (and (on ?i gripper) (rubbish ?i))
        :effect (and (in ?i ?b) (hand-empty) (not (on ?i gripper)) (increase (total-cost) 1)))

    (:action open-drawer
        :parameters (?d - drawer)
        :precondition (and (hand-empty) (not (open ?d)))
        :effect (and (open ?d) (increase (total-cost) 2.5)))

    (:action close-drawer
        :parameters (?d - drawer)
        :precondition (and (hand-empty) (open ?d))
        :effect (and (not (open ?d)) (increase (total-cost) 2.5)))

    (:action turn-off
        :parameters (?s - switch)
        :precondition (and (hand-empty) (lit ?s))
        :effect (and (not (lit ?s)) (increase (total-cost) 1)))

    (:action turn-on
        :parameters (?s - switch)
        :precondition (and (hand-empty) (not (lit ?s)))
        :effect (and (lit ?s) (increase (total-cost) 1)))

    (:action close-faucet
        :parameters (?f - faucet)
        :precondition (and (hand-empty) (running ?f))
        :effect (and (not (running ?f)) (increase (total-cost) 1)))

    ; Looking around: tidy when no rubbish lies about and every drawer is shut.
    (:action inspect
        :parameters ()
        :precondition (and
            (forall (?i - item) (or (not (rubbish ?i)) (exists (?b - bin) (in ?i ?b))))
            (forall (?d - drawer) (not (open ?d))))
        :effect (and (tidy) (increase (total-cost) 1))))
