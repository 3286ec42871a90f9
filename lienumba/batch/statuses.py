"""How a run may end."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Status:
    """`name`: one word for the dataset's flag_meanings; `sentence`: what it means, for people; `former`: what older
    files call it."""

    code: int
    name: str
    sentence: str
    former: str = ""


SUCCESS, NON_FINITE, NOT_CONVERGED, SINGULAR, ROTATION, NOT_ASSEMBLED, INVALID = range(7)
STEP_TOO_SHORT, STOPPED = 8, 9  # 7: of a run that goes again (`codes.RESELECT`)
NOT_CLOSED, CHATTERING, PARADOX, UNSOLVED, UNSETTLED, UNDEFINED, NO_EQUILIBRIUM, PUSHED, CONTRADICTS, VIOLATED = range(
    10, 20
)
GOOD = (SUCCESS, STOPPED)

IMPLICIT = "an implicit method (radau5) where a force is stiff"

STATUSES = (
    Status(SUCCESS, "success", "finished"),
    Status(
        NON_FINITE,
        "non_finite",
        f"the state became infinite or undefined; try a smaller step, or {IMPLICIT}",
    ),
    Status(
        NOT_CONVERGED,
        "projection_not_converged",
        f"the projection did not reach its tolerance; try a smaller step, or {IMPLICIT}, or see whether a driver wants "
        "more than the mechanism can reach",
    ),
    Status(
        SINGULAR,
        "singular_constraints",
        "joints or drivers could not be kept where they depend on one another (a dead point); start elsewhere, or "
        "drive another joint",
    ),
    Status(
        ROTATION,
        "rotation_too_large",
        "a body turned too far in one step: by nearly a full turn, by a quarter of one where the angle of a joint is "
        "counted, or by 1 rad where a contact turns with it, or its angles did in a gimbal lock; try a smaller step, "
        f"{IMPLICIT}, or other coordinates, or see whether a driver wants more than the mechanism can reach",
    ),
    Status(
        NOT_ASSEMBLED,
        "not_assembled",
        "no initial state that fulfils the joints, and in which no contact overlaps, was found for the sampled values; "
        "give fewer initial values, or less spread",
    ),
    Status(
        INVALID,
        "invalid_sample",
        "a sampled mass, inertia, length or speed of friction is not positive, or a rotation is zero; give less spread",
    ),
    Status(
        STEP_TOO_SHORT,
        "step_too_short",
        "the tolerance asks for a step below the shortest, or for 100,000 within a thousandth of the run; give a "
        f"larger tolerance or a smaller integrator.min_step, {IMPLICIT}, or see whether a force jumps, or a disc falls "
        "flat on a plane: one that is to lie there needs points on its edge",
    ),
    Status(STOPPED, "stopped_by_event", "ended by an event, as asked for"),
    Status(
        NOT_CLOSED,
        "capture_failed",
        "a joint was to be engaged whose parts were further apart than events.closing, or are kept apart by others; "
        "engage it where they meet, or give a larger closing",
        former="not_closed",
    ),
    Status(
        CHATTERING,
        "chattering",
        "contacts, friction or events changed again and again without end at nearly one time; give contacts a "
        "rest_speed, or events that undo each other some width between their conditions",
    ),
    Status(
        PARADOX,
        "friction_paradox",
        "friction pushes a sliding contact into its partner, so that no acceleration fits (Painleve's paradox); give "
        "less friction, or a compliant contact",
    ),
    Status(
        UNSOLVED,
        "contacts_not_solved",
        "the impulses or forces of contacts were not found; give less friction, or fewer contacts that say the same",
    ),
    Status(
        UNSETTLED,
        "stages_not_solved",
        "the equations of an implicit step were not solved, also in much shorter steps; see whether a force jumps, or "
        "take an explicit method",
    ),
    Status(
        UNDEFINED,
        "undefined_quantity",
        "the motion is there, but a quantity or reaction that is stored or summed up became infinite or undefined, as "
        "the root of a negative number is; write its formula so that it has a value everywhere, or see whether numbers "
        "of the model are too large or too small",
    ),
    Status(
        NO_EQUILIBRIUM,
        "no_equilibrium",
        "no equilibrium was found in which the run could start: there is none, it is too far from where the search "
        "begins, it lies beyond a stop, or it would not last while it turns; ask lienumba equilibrium, give a start.q "
        "or a guess nearer to it, or leave start.from out",
    ),
    Status(
        PUSHED,
        "friction_energy_gain",
        "something slid along its friction instead of against it, so that friction gave energy; give a smaller "
        "tolerance or a max_step, or less friction",
        former="friction_pushes",
    ),
    Status(
        CONTRADICTS,
        "inconsistent_constraints",
        "joints, locks, stops and drivers that hold at once ask for different motions, as where something engages or "
        "hits what a driver goes on moving, or is locked in a dead point; let go of one of them before, or drive by a "
        "force",
        former="contradiction",
    ),
    Status(
        VIOLATED,
        "contact_law_violated",
        "a contact, a stop or what sticks did what it cannot, by more than a millionth of its forces, speeds or size: "
        "it pulled, overlapped, moved while it was closed, or held by more than its friction; give a smaller tolerance "
        "or a max_step, or other coordinates, or see whether surfaces touch where they have one tangent",
        former="contact_violated",
    ),
)
