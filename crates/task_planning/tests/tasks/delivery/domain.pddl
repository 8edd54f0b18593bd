; Doors, keys and parcels: enough dead ends to make "no plan" interesting. Written for Factotum.
(define (domain delivery)
    (:requirements :strips :typing)
    (:types room door key parcel - object)
    (:predicates
        (robot-in ?r - room)
        (between ?d - door ?a - room ?b - room)
        (unlocked ?d - door)
        (fits ?k - key ?d - door)
        (key-in ?k - key ?r - room)
        (parcel-in ?p - parcel ?r - room)
        (has-key ?k - key)
        (carries ?p - parcel)
        (free))

    (:action go
        :parameters (?d - door ?a - room ?b - room)
        :precondition (and (robot-in ?a) (between ?d ?a ?b) (unlocked ?d))
        :effect (and (robot-in ?b) (not (robot-in ?a))))

    (:action unlock
        :parameters (?k - key ?d - door ?a - room ?b - room)
        :precondition (and (robot-in ?a) (between ?d ?a ?b) (has-key ?k) (fits ?k ?d))
        :effect (unlocked ?d))

    (:action take-key
        :parameters (?k - key ?r - room)
        :precondition (and (robot-in ?r) (key-in ?k ?r))
        :effect (and (has-key ?k) (not (key-in ?k ?r))))

    (:action take
        :parameters (?p - parcel ?r - room)
        :precondition (and (robot-in ?r) (parcel-in ?p ?r) (free))
        :effect (and (carries ?p) (not (parcel-in ?p ?r)) (not (free))))

    (:action drop
        :parameters (?p - parcel ?r - room)
        :precondition (and (robot-in ?r) (carries ?p))
        :effect (and (parcel-in ?p ?r) (free) (not (carries ?p)))))
