; Coffee preparation with a mobile manipulator (dissertation 5.4, hardware demonstration): the robot
; gathers grounds and water, pours both into the machine, closes its lid and pushes its button.
; Written for Factotum; where the base must stand is left to navigation symbols.
(define (domain coffee)
    (:requirements :strips :typing :negative-preconditions)
    (:types
        item machine surface - object
        vessel - item)
    (:predicates
        (hand-empty)
        (holding ?v - vessel)
        (at ?v - vessel ?s - surface)
        (full ?v - vessel)
        (holds-water ?v - vessel)
        (holds-grounds ?v - vessel)
        (has-water ?m - machine)
        (has-grounds ?m - machine)
        (lid-open ?m - machine)
        (brewed ?m - machine))

    (:action PickUp
        :parameters (?v - vessel ?s - surface)
        :precondition (and (hand-empty) (at ?v ?s))
        :effect (and (holding ?v) (not (hand-empty)) (not (at ?v ?s))))

    (:action Place
        :parameters (?v - vessel ?s - surface)
        :precondition (holding ?v)
        :effect (and (at ?v ?s) (hand-empty) (not (holding ?v))))

    (:action Pour
        :parameters (?v - vessel ?m - machine)
        :precondition (and (holding ?v) (full ?v) (lid-open ?m))
        :effect (and
            (not (full ?v))
            (when (holds-water ?v) (has-water ?m))
            (when (holds-grounds ?v) (has-grounds ?m))))

    (:action CloseLid
        :parameters (?m - machine)
        :precondition (and (hand-empty) (lid-open ?m))
        :effect (not (lid-open ?m)))

    (:action PushButton
        :parameters (?m - machine)
        :precondition (and
            (hand-empty) (has-water ?m) (has-grounds ?m) (not (lid-open ?m)))
        :effect (brewed ?m)))
