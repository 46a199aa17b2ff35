import os
import signal
from itertools import permutations, product

import pytest
from assembly_problems import ALL_SIDES, block, problem_of

from mission_computer.assembly.constraint_model import DispatchModel, SolverLimits
from mission_computer.assembly.cut_tree import CutForest
from mission_computer.assembly.dispatching import DispatchLimits, dispatches
from mission_computer.assembly.generated import Outline, generate_problem
from mission_computer.assembly.local_search import LocalSearch, LocalSearchLimits, even_tree
from mission_computer.assembly.map_library import load_problem
from mission_computer.assembly.structure import Structure
from mission_computer.assembly.tabu_search import TabuLimits, TabuSearch, tabu_dispatch
from mission_computer.assembly.travel import least_longest_travel
from swarm_msgs_py.assembly.docking import docked_contacts
from swarm_msgs_py.assembly.faces import Gender, distinct_turns
from swarm_msgs_py.assembly.plan import Dispatch
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.errors import NoDispatchError
from swarm_msgs_py.randomness import rng_for

LIMITS = SolverLimits(seed=1, work=5.0)
CORNERS = [(1, 1, 0, 0), (1, 0, 0, 1), (0, 0, 1, 0), (0, 1, 0, 1), (1, 0, 0, 0)]


def is_separable(problem: AssemblyProblem, dispatch: Dispatch) -> bool:
    structure = Structure(problem.targets)
    docked = docked_contacts(problem.targets, dispatch.layouts(problem), problem.gender)
    return CutForest(structure, docked).is_separable(structure.whole)


def least_longest_by_enumeration(problem: AssemblyProblem) -> int | None:
    """Return the least longest travel of all separable dispatches."""
    found = [
        dispatch.longest_travel(problem)
        for boats in permutations(range(problem.boat_count), problem.target_count)
        for turns in product(*(distinct_turns(problem.layouts[boat]) for boat in boats))
        if is_separable(problem, dispatch := Dispatch(boats, turns))
    ]
    return min(found, default=None)


@pytest.mark.parametrize("rotation", range(3))
def test_the_constraint_program_finds_the_least_longest_travel(rotation: int) -> None:
    layouts = (CORNERS[rotation:] + CORNERS[:rotation])[:4]
    problem = problem_of([(12, 12), (12, 13), (13, 12)], layouts)
    best = least_longest_by_enumeration(problem)

    first = next(dispatches(problem, Structure(problem.targets), 1, DispatchLimits(feasible_work=5.0)))

    assert first.longest_travel(problem) == best
    assert is_separable(problem, first)


def test_a_bound_below_the_least_longest_travel_is_proven_infeasible() -> None:
    problem = problem_of([(12, 12), (12, 13), (13, 12)], CORNERS[:4])
    best = least_longest_by_enumeration(problem)
    assert best is not None

    solution = DispatchModel(problem, Structure(problem.targets), best - 1).solve(LIMITS)

    assert solution.dispatch is None
    assert solution.is_proof


def test_who_was_to_hear_an_interruption_still_does_after_a_search() -> None:
    problem = problem_of([(12, 12), (12, 13), (13, 12)], CORNERS[:4])
    child = os.fork()
    if child == 0:
        signal.signal(signal.SIGINT, lambda *_: os._exit(0))
        DispatchModel(problem, Structure(problem.targets), 99).solve(LIMITS)
        os.kill(os.getpid(), signal.SIGINT)
        os._exit(1)

    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


def test_layouts_that_cannot_join_are_refused_with_a_proof() -> None:
    problem = problem_of(block(3, 1), [(1, 0, 0, 0)] * 3)  # the middle one would need two sides

    with pytest.raises(NoDispatchError, match=r"no dispatch lets .* \(3 equipped sides\) .* \(proven\)"):
        next(dispatches(problem, Structure(problem.targets), 1, DispatchLimits()))


def test_equal_genders_are_refused_where_genderless_sides_would_join() -> None:
    cells, layouts = block(2, 1), [(1, 0, 0, 0), (1, 0, 0, 0)]
    structure = Structure(cells)

    assert next(dispatches(problem_of(cells, layouts), structure, 1, DispatchLimits()))
    with pytest.raises(NoDispatchError, match="proven"):
        next(dispatches(problem_of(cells, layouts, gender=Gender.OPPOSITE), structure, 1, DispatchLimits()))


def test_one_target_takes_the_nearest_boat_even_without_mechanisms() -> None:
    problem = problem_of([(12, 12)], [(0, 0, 0, 0)] * 3)

    found = next(dispatches(problem, Structure(problem.targets), 1, DispatchLimits()))

    assert found.boats == (2,)


@pytest.mark.parametrize("gender", Gender)
def test_local_search_docks_across_every_cut(gender: Gender) -> None:
    problem = generate_problem(Outline.BLOCK, 48, gender, 3)
    structure = Structure(problem.targets)
    tree = even_tree(structure)
    assert tree is not None

    bound = least_longest_travel(problem) + 4
    found = LocalSearch(problem, structure, tree, bound, rng_for(1, "test")).run(LocalSearchLimits())

    assert found is not None
    assert is_separable(problem, found)
    assert len(set(found.boats)) == 48


@pytest.mark.parametrize("gender", Gender)
def test_tabu_search_joins_map_1(gender: Gender) -> None:
    problem = load_problem("map_1", gender)

    found = tabu_dispatch(problem, Structure(problem.targets), rng_for(1, "tabu"), TabuLimits())

    assert is_separable(problem, found.best.dispatch)
    assert found.feasible >= 1


def test_tabu_search_counts_pieces_as_the_docking_graph_has_them() -> None:
    problem = problem_of(block(3, 1), [(1, 0, 0, 0)] * 3)
    search = TabuSearch(problem, Structure(problem.targets), rng_for(1, "tabu"), TabuLimits(iterations_max=200))

    found, _ = search.run()

    assert not found
    assert search.least_pieces == 2


def test_tabu_search_says_how_near_it_came() -> None:
    problem = problem_of(block(3, 1), [(1, 0, 0, 0)] * 3)

    with pytest.raises(NoDispatchError, match="the best leaves 2 pieces"):
        tabu_dispatch(problem, Structure(problem.targets), rng_for(1, "tabu"), TabuLimits(iterations_max=200))


def test_equal_seeds_give_equal_dispatches() -> None:
    problem = load_problem("map_1", Gender.OPPOSITE)
    structure = Structure(problem.targets)
    limits = TabuLimits(iterations_max=400)

    one, other = (tabu_dispatch(problem, structure, rng_for(5, "tabu"), limits) for _ in range(2))

    assert one == other


def test_the_bound_of_all_travels_is_that_of_a_matching() -> None:
    problem = problem_of([(1, 5), (2, 5)], [ALL_SIDES] * 2, starts=[(1, 1), (4, 1)])

    assert least_longest_travel(problem) == 6  # 4 and 2 + 4; crossed over 5 and 3 + 4
