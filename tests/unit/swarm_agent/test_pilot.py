from assembly_problems import ALL_SIDES, block, problem_of

from swarm_agent.assembly.boat import Boat, BoatInputs, merged_words
from swarm_agent.assembly.crew import Orders
from swarm_agent.assembly.pilot import Pilot, PilotConfig, Sight
from swarm_msgs_py.assembly.boat_frames import BoatFrame, Move, Phase
from swarm_msgs_py.assembly.plan import AssemblyTree, Axis, Dispatch, Guideposts, TreeNode

PROBLEM = problem_of(block(3, 1), [ALL_SIDES] * 3)  # cells (12, 12), (13, 12), (14, 12)
TREE = AssemblyTree(
    (
        TreeNode((0, 1, 2), -1, (1, 2), Axis.X, 13),
        TreeNode((0, 1), 0, (3, 4), Axis.X, 12),
        TreeNode((2,), 0),
        TreeNode((0,), 1),
        TreeNode((1,), 1),
    )
)
# The center is the middle cell: boat 0 and boat 2 come to boat 1, first 0, then 2.
ORDERS = Orders(PROBLEM, Dispatch((0, 1, 2), (0, 0, 0)), TREE, Guideposts(((0, 0), (0, 0), (3, 0), (-3, 0), (0, 0))))
CONFIG = PilotConfig()


def words(boat: int, node: int, shift: tuple[int, int], move: Move = Move.STAY, **more: bool) -> BoatFrame:
    return BoatFrame(Phase.CLAIM, boat, 1, node, shift, move, **more)


def sight(*frames: BoatFrame, unheard: tuple[tuple[int, int], ...] = ()) -> Sight:
    return Sight({frame.boat: frame for frame in frames}, unheard)


def test_a_visitor_waits_at_its_guidepost_for_its_partner() -> None:
    claim = Pilot(ORDERS, CONFIG).claim(0, 1, 3, (-3, 0), sight(words(1, 4, (0, 5))))

    assert claim.move is Move.STAY


def test_a_visitor_drives_straight_in_once_its_partner_stands() -> None:
    pilot = Pilot(ORDERS, CONFIG)
    seen = sight(words(1, 4, (0, 0)), words(2, 2, (3, 0)))

    claim = pilot.claim(0, 1, 3, (-3, 0), seen)

    assert (claim.move, claim.is_docking) == (Move.RIGHT, True)
    assert pilot.decide(claim, seen) is Move.RIGHT


def test_a_docking_group_waits_while_its_partner_moves() -> None:
    pilot = Pilot(ORDERS, CONFIG)
    claim = pilot.claim(0, 1, 3, (-3, 0), sight(words(1, 4, (0, 0))))

    assert pilot.decide(claim, sight(words(1, 4, (0, 0), Move.UP))) is Move.STAY


def test_of_two_claims_that_are_too_near_the_lower_rank_stays() -> None:
    low, high = words(2, 2, (0, -6), Move.LEFT), words(0, 3, (-1, -6), Move.RIGHT)  # cells 14 and 11, to 13 and 12

    assert Pilot(ORDERS, CONFIG).decide(low, sight(high)) is Move.STAY
    assert Pilot(ORDERS, CONFIG).decide(high, sight(low)) is Move.RIGHT


def test_a_visitor_comes_near_while_the_parts_of_its_partner_join() -> None:
    parts = words(0, 3, (-3, 0), Move.RIGHT), words(1, 4, (0, 0))

    claims = [Pilot(ORDERS, CONFIG).claim(2, 1, 2, (x, 0), sight(*parts)) for x in (3, 1)]

    assert [(claim.move, claim.is_docking) for claim in claims] == [(Move.LEFT, False), (Move.STAY, False)]


def test_a_claim_that_is_blocked_itself_blocks_nobody() -> None:
    mine = words(2, 2, (-1, -4), Move.LEFT)  # from (13, 8) to (12, 8)
    other = words(0, 3, (-1, -6), Move.UP)  # from (11, 6) to (11, 7), of higher rank and too near to that
    blocker = words(1, 4, (-3, -4))  # at (10, 8), too near to (11, 7)

    assert Pilot(ORDERS, CONFIG).decide(mine, sight(other)) is Move.STAY
    assert Pilot(ORDERS, CONFIG).decide(mine, sight(other, blocker)) is Move.LEFT


def test_nobody_moves_to_where_an_unheard_boat_could_go() -> None:
    claim = words(0, 3, (-3, 0), Move.UP)  # from (9, 12) to (9, 13)

    assert Pilot(ORDERS, CONFIG).decide(claim, sight(unheard=((9, 16),))) is Move.UP
    assert Pilot(ORDERS, CONFIG).decide(claim, sight(unheard=((9, 15),))) is Move.STAY


def test_two_boats_that_stand_docked_are_one_group_for_all_who_hear_them() -> None:
    merged = merged_words(ORDERS, [words(0, 3, (0, 0)), words(1, 4, (0, 0)), words(2, 2, (3, 0))])

    assert [(one.boat, one.node) for one in merged] == [(0, 1), (2, 2)]


def test_a_boat_joins_its_partner_and_the_lower_number_leads() -> None:
    boats = [Boat(number, ORDERS, CONFIG) for number in (0, 1)]
    cells = [(12, 12), (13, 12)]
    looks = [boats[n].step(BoatInputs(1, Phase.LOOK, cells[n], (cells[1 - n],), ())).frame for n in (0, 1)]
    heard = [frame for frame in looks if frame is not None]

    claims = [boats[n].step(BoatInputs(1, Phase.CLAIM, cells[n], (), [heard[1 - n]])) for n in (0, 1)]

    assert [claim.node for claim in claims] == [1, 1]
    assert claims[0].frame is not None
    assert claims[1].frame is None


def test_a_leader_that_missed_a_boat_of_its_crew_stays() -> None:
    boat = Boat(0, ORDERS, CONFIG)
    partner = BoatFrame(Phase.LOOK, 1, 1, 4, (-1, -6))
    boat.step(BoatInputs(1, Phase.LOOK, (12, 12), (), ()))
    boat.step(BoatInputs(1, Phase.CLAIM, (12, 12), (), [BoatFrame(Phase.LOOK, 1, 1, 4, (0, 0)), partner][:1]))

    boat.step(BoatInputs(2, Phase.LOOK, (12, 12), (), ()))
    boat.step(BoatInputs(2, Phase.CLAIM, (12, 12), (), ()))

    assert boat.step(BoatInputs(2, Phase.GO, (12, 12), (), ())).move is Move.STAY
