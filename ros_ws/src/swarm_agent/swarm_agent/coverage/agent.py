"""One robot of the coverage family: gathers at the leader, takes a place, travels to it, holds it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from swarm_agent.coverage.absence import AbsenceWatch, patience_under_way
from swarm_agent.coverage.board import Board
from swarm_agent.coverage.config import CoverageConfig, Expansion, Rule
from swarm_agent.coverage.flock import Flock
from swarm_agent.coverage.frames import NOBODY, Frame, Key, Mission, Place, State, decode, on_air
from swarm_agent.coverage.leading import Leading, solid_of
from swarm_agent.coverage.offers import Offers
from swarm_agent.coverage.release import Release
from swarm_agent.coverage.rendezvous import INFINITE, Rendezvous
from swarm_agent.coverage.surroundings import Surroundings
from swarm_agent.coverage.telling import Telling
from swarm_agent.coverage.travel import Travel
from swarm_agent.coverage.turns import Turns
from swarm_agent.coverage.unfolding import Unfolding, may_unfold
from swarm_agent.coverage.whereabouts import Scale, company, farthest_off, located, nearest_holder, toward, upstream
from swarm_msgs_py.coverage_io import CoverageInputs, CoverageMode, CoverageOutputs, CoverageReport
from swarm_msgs_py.coverage_orders import CoverageOrder, decode_order, is_order
from swarm_msgs_py.errors import FrameError, ShapeError
from swarm_msgs_py.geometry.solids.barriers import OPEN_SPACE, Barriers
from swarm_msgs_py.geometry.solids.solid import Solid
from swarm_msgs_py.types import FloatArray, NodeId

TREE_LINK = 0.98  # edges of the rendezvous tree, in ranges: who travels along them may be a little off
LINK_SPARE = 1e-3  # of the range: links between places are strictly shorter, wherever within its tolerance one stands
ROOT_NUMBER = 0  # of the leader's own place
AT_REST = np.zeros(3)
AT_REST.flags.writeable = False


class CoverageAgent:
    """A robot; `step` is all that it does.

    Parameters
    ----------
    me : NodeId
    config : CoverageConfig
    period : float
        Of a tick [s].
    seed : int
        Of what the robots draw by lot; the same for all.
    is_leader : bool
        Whether it leads from the start: it is told where it is, and obeys the operator. Whoever takes the place of a
        leader that has died leads from then on.
    barriers : Barriers, optional
        Obstacles on the map.
    """

    def __init__(  # noqa: PLR0913 - what one robot is and has been told
        self,
        me: NodeId,
        config: CoverageConfig,
        period: float,
        seed: int,
        *,
        is_leader: bool = False,
        barriers: Barriers = OPEN_SPACE,
    ) -> None:
        self.id = me
        self._config, self._period, self._seed, self._barriers = config, period, seed, barriers
        self._mission = Mission(1, me if is_leader else NOBODY, b"")
        self._mode = CoverageMode.GATHERING
        self._modes: dict[NodeId, CoverageMode] = {}
        self._order = CoverageOrder(0)
        self._leading: Leading | None = None
        self._flock = Flock(period)
        self._position: FloatArray | None = None
        self._solid: Solid | None = None
        self._telling = Telling(me, config.protocol)
        self._gather()

    def step(self, inputs: CoverageInputs) -> CoverageOutputs:
        """Advance by one tick."""
        around, mode = Surroundings(inputs), self._mode
        frames = self._received(inputs.inbox)
        self._learn(inputs.tick, frames)
        if self._is_leading and self._order.number > self._mission.order:
            self._obey(self._order, inputs.tick)
        velocity = self._act(inputs, frames, around)
        if self._position is not None and self._mode is not CoverageMode.HOLDING:
            self._position = self._position + self._period * velocity  # until it is measured again
        velocity = velocity + self._flock.drift(inputs.tick)
        tells_tree = self._mode is CoverageMode.GATHERING or not self._mission.shape
        outbox = self._telling.outbox(
            inputs.tick,
            self._mode,
            self._mission,
            self._rendezvous.news(inputs.tick) if tells_tree else None,
            has_changed=mode is not self._mode or inputs.tick == 0,
        )
        return CoverageOutputs(inputs.tick, velocity, outbox, self._report())

    # -- hearing ---------------------------------------------------------------------------------------------------

    def _received(self, inbox: tuple[bytes, ...]) -> list[Frame]:
        """Return the frames of other robots; take orders in, and pass them on once. What is neither is dropped."""
        frames = []
        for data in inbox:
            try:
                if not is_order(data):
                    frames.append(decode(data))
                elif decode_order(data).number > self._order.number:
                    self._order = decode_order(data)
                    self._telling.pass_on(data)
            except FrameError:
                continue
        return frames

    def _learn(self, tick: int, frames: list[Frame]) -> None:
        """Take in what neighbors know: their modes, the mission, the board."""
        for frame in frames:
            self._modes[frame.sender] = frame.mode
            if frame.mission is not None and frame.mission.term > self._mission.term:
                self._adopt(frame.mission)
            # Robots without a place are leaves of the backbone: nobody needs them to pass news on, or to answer.
            # But who is to gather may be new here; it asks by telling that it knows nothing.
            is_holding = self._mode is CoverageMode.HOLDING
            answers = is_holding or self._mode is CoverageMode.GATHERING
            self._telling.hear(tick, frame, passes_on=is_holding, answers=answers)

    @property
    def _is_leading(self) -> bool:
        """Whether it obeys the operator: the leader, until it dies; then whoever holds its place."""
        if self._mode is CoverageMode.HOLDING:
            return self._place == self._root
        return self._mission.leader == self.id

    @property
    def _root(self) -> Key:
        return self._mission.leader, ROOT_NUMBER

    def _obey(self, order: CoverageOrder, tick: int) -> None:
        """Cover a shape, for which a swarm that has begun gathers again, or set it moving (spec section 8)."""
        mission = replace(self._mission, order=order.number)
        if order.shape:
            try:
                self._leading = Leading(order.shape, self._seed)
            except (FrameError, ShapeError):
                self._mission = mission  # an order that cannot be obeyed
                return
            if self._mission.shape:
                self._adopt(replace(mission, term=mission.term + 1, leader=self.id, shape=b""))
            else:
                self._mission = mission
        elif self._mission.shape:  # else it is obeyed as soon as there is a formation
            since = tick + self._config.protocol.flock_notice_ticks
            self._adopt(replace(mission, term=mission.term + 2, since=since, velocity=order.velocity))

    def _adopt(self, mission: Mission) -> None:
        """Follow a newer mission: odd terms gather, even ones expand."""
        self._flock.follow(mission)
        self._mission = mission
        if mission.term % 2:
            self._mode = CoverageMode.GATHERING
            self._gather()
        elif mission.shape:
            self._solid = solid_of(mission.shape)
            if self._mode is CoverageMode.GATHERING:  # a straggler, or a newcomer
                self._mode = CoverageMode.WAITING
        self._telling.tell_mission()

    def _gather(self) -> None:
        is_root = self._mission.leader == self.id
        self._rendezvous = Rendezvous(
            self.id,
            is_root=is_root,
            term=self._mission.term,
            absence_ticks=patience_under_way(self._config.protocol, self._barriers),
            edge_ticks=int(np.ceil(self._config.range_m / (self._config.motion.speed_mps * self._period))),
        )
        link = (1.0 - LINK_SPARE) * self._config.range_m - self._arrival
        self._board = Board(link, self._arrival, self._barriers)
        self._telling.begin(self._board)
        self._absence = AbsenceWatch(self.id, self._config, self._period, self._barriers)
        self._solid = None
        self._place: Key | None = None
        self._travel: Travel | None = None
        self._unfolding: Unfolding | None = None
        self._offers: Offers | None = None
        self._release: Release | None = None
        self._turns = Turns(self.id, self._config)

    # -- acting ----------------------------------------------------------------------------------------------------

    def _act(self, inputs: CoverageInputs, frames: list[Frame], around: Surroundings) -> FloatArray:
        """Return the velocity, in the frame of the flock."""
        if self._mode is CoverageMode.GATHERING:
            return self._gathering(inputs, frames, around)
        if self._mode is CoverageMode.WAITING:
            return self._led(inputs) if self._is_leading else self._waiting(inputs, around)
        if self._mode is CoverageMode.TRAVELING:
            return self._traveling(inputs, around)
        return self._holding(inputs, around)

    def _gathering(self, inputs: CoverageInputs, frames: list[Frame], around: Surroundings) -> FloatArray:
        """Rendezvous (eqs. (6)-(8))."""
        self._rendezvous.hear(inputs.tick, frames, around, TREE_LINK * self._config.range_m)
        has_met = self._rendezvous.advance(inputs.tick, around, self._arrival)
        if has_met or (self._is_leading and inputs.time > self._config.protocol.gather_limit_s):
            self._mode = CoverageMode.WAITING
        return toward(around.offset(self._rendezvous.target), self._config.motion, self._period)

    def _led(self, inputs: CoverageInputs) -> FloatArray:
        """Drive to the shape; once there, say what to do."""
        here = self._position if inputs.position is None else inputs.position - self._flock.shift(inputs.tick)
        if self._leading is None or here is None:  # nothing is ordered yet
            return AT_REST
        velocity = self._leading.approach(here, self._config, self._period)
        if velocity is not None:
            return velocity
        self._adopt(replace(self._mission, term=self._mission.term + 1, leader=self.id, shape=self._leading.shape))
        self._position, self._mode = here, CoverageMode.HOLDING
        self._hold(self._root, 0, inputs.tick)
        if self._config.rule is Rule.LAYOUT:
            for number, place in enumerate(self._leading.places(here, self._config, self._barriers), start=1):
                self._telling.say(Place((self.id, number), 0, State.OPEN, NOBODY, place), inputs.tick)
        return AT_REST

    def _waiting(self, inputs: CoverageInputs, around: Surroundings) -> FloatArray:
        """Take a place, or stay with the leader."""
        if self._travel is not None:
            return self._returning(self._travel, around)
        place = None
        if self._solid is not None:
            place = self._turns.place(inputs.tick, around, self._modes, self._board, self._root)
        nearest = nearest_holder(around, self._board.held) if place is not None else None
        if place is None or nearest is None:
            root = self._board.get(self._root)
            leader = self._rendezvous.met if root is None else root.holder
            offset = company(around, leader, self._board.held, self._config.range_m)
            if offset is None and root is not None and self._position is not None:
                offset = np.array(root.position) - self._position  # by dead reckoning, until somebody is sensed
            return toward(offset, self._config.motion, self._period, self._arrival)
        self._telling.say(Place(place.key, place.version, State.TAKEN, self.id, place.position), inputs.tick)
        self._place = place.key
        self._travel = Travel(place, self._board.held[nearest[0]].key, self._config)
        away = around.distance(nearest[0])
        if self._predicts and not self._barriers and may_unfold(self._board, self._root, away, self._config):
            self._unfolding = Unfolding(self._root, place.key, self._board, self._config, inputs.tick, self._period)
        expected = self._travel.expected_ticks(self._board, self._period)
        if self._unfolding is not None:  # who has a short way is to take as long as all others
            expected = max(expected, self._unfolding.ticks)
        self._limit = self._config.protocol.travel_limit * (expected + self._config.protocol.heartbeat_ticks)
        self._mode = CoverageMode.TRAVELING
        return self._traveling(inputs, around)

    @property
    def _predicts(self) -> bool:
        return self._config.expansion is Expansion.PREDICTED

    def _traveling(self, inputs: CoverageInputs, around: Surroundings) -> FloatArray:
        """Follow the way; on arrival switch the sensor on (Algorithm 2)."""
        assert self._travel is not None
        assert self._place is not None
        place = self._board.get(self._place)
        if place is None or place.holder != self.id or place.state is not State.TAKEN:  # somebody else was quicker
            return self._stray()
        if self._travel.ticks > self._limit:  # [I9]
            self._telling.say(self._board.freed(place, State.OPEN), inputs.tick)
            return self._stray()
        here = located(around, self._board.held)
        is_exact = here is not None
        if here is None and self._unfolding is not None:
            here = self._unfolding.located(inputs.tick, self._board, around)
        if here is not None:
            self._position = here
        if self._position is None:
            return AT_REST
        offset = np.array(place.position) - self._position
        if is_exact and np.linalg.norm(offset) <= self._arrival:
            self._mode = CoverageMode.HOLDING
            self._hold(place.key, place.version, inputs.tick)
            return AT_REST
        if self._unfolding is not None:
            self._travel.ticks += 1
            target: FloatArray | None = self._unfolding.target(
                inputs.tick, self._position, self._board, around, is_exact=is_exact
            )
        else:
            target = self._travel.target(self._position, self._board, around)
        return AT_REST if target is None else toward(target - self._position, self._config.motion, self._period)

    def _stray(self) -> FloatArray:
        self._mode, self._place, self._travel, self._unfolding = CoverageMode.WAITING, None, None, None
        return AT_REST

    def _holding(self, inputs: CoverageInputs, around: Surroundings) -> FloatArray:
        """Hold the place, offer others next to it, and notice who is gone."""
        assert self._place is not None
        assert self._position is not None
        place = self._board.get(self._place)
        if place is None or place.holder != self.id:  # taken for dead: it is not
            version = place.version + 1 if place is not None else 0
            self._hold(self._place, version, inputs.tick)
        for lost in self._absence.gone(inputs.tick, self._position, self._board, around):
            # The root of all ways is filled again under any rule: whoever holds it takes the leader's place.
            refill = self._config.rule is Rule.LAYOUT or lost.key == self._root
            self._telling.say(self._board.freed(lost, State.OPEN if refill else State.WITHDRAWN), inputs.tick)
        if self._offers is not None:
            self._telling.tell(self._offers.refresh(inputs.tick, self._board), inputs.tick)
        if place is not None and self._release is not None and self._release.is_due(inputs.tick, self._board):
            return self._leave(inputs.tick, place, around)
        return AT_REST if place is None else self._station(inputs, around, place)

    def _hold(self, key: Key, version: int, tick: int) -> None:
        """Announce the own place (EnableSensor)."""
        assert self._position is not None
        assert self._solid is not None
        place = Place(key, version, State.HELD, self.id, on_air(self._position))
        self._place, self._unfolding = key, None
        self._telling.say(place, tick)
        if self._config.rule is not Rule.LAYOUT:
            self._offers = Offers(self.id, place, self._root, self._solid, self._config, self._seed, self._barriers)
        if self._config.rule is Rule.GAIN:
            self._release = Release(key, self._root, self._solid, self._config)

    def _leave(self, tick: int, place: Place, around: Surroundings) -> FloatArray:
        """Give up a place that the others do without, and set out for the leader."""
        self._telling.say(replace(place, state=State.NEEDLESS), tick)
        self._stray()
        self._offers = self._release = None
        nearest, root = nearest_holder(around, self._board.held), self._board.get(self._root)
        if nearest is not None and root is not None:
            self._travel = Travel(root, self._board.held[nearest[0]].key, self._config)
        return AT_REST

    def _returning(self, travel: Travel, around: Surroundings) -> FloatArray:
        """Go over places that are held until the leader is near enough to go straight to it."""
        here = located(around, self._board.held)
        self._position = self._position if here is None else here
        assert self._position is not None
        target = travel.target(self._position, self._board, around)
        away = float(np.linalg.norm(np.array(travel.goal.position) - self._position))
        if target is None or away <= self._config.placement * self._config.range_m:
            self._travel = None
            return AT_REST
        return toward(target - self._position, self._config.motion, self._period)

    def _station(self, inputs: CoverageInputs, around: Surroundings, place: Place) -> FloatArray:
        """Return the velocity back to the own place, if it has been left: station keeping [I4, I12].

        The leader knows where it is; the others keep to the next robot toward it, so that what each link is off comes
        from one step of two robots. A formation that moves is a little smaller: noise shakes all of it.
        """
        root = self._board.get(self._root)
        if root is None:
            return AT_REST
        motion, is_moving = self._config.motion, self._flock.drift(inputs.tick).any()
        # At rest, only what shakes a robot moves it: to correct what is within the noise would do no good.
        near = motion.station_m if is_moving or motion.drifts else max(motion.station_m, self._arrival)
        scale = Scale(np.array(root.position), self._flock.contraction(inputs.tick, self._config))
        target = scale.placed(np.array(place.position))
        if inputs.position is not None:
            offset = target - (inputs.position - self._flock.shift(inputs.tick))
        elif farthest_off(target, around, self._board.held, scale) <= near:
            return AT_REST  # whoever is nearer to the leader, which takes a search of the whole board
        else:
            hops = self._board.hops_from(self._root, over_taken=False)
            before = upstream(around, self._board.held, hops, place.key, self._config)
            if not before:
                return AT_REST
            anchors = scale.placed(np.array([self._board.held[robot].position for robot, _ in before]))
            offset = target - (anchors - np.array([there for _, there in before])).mean(axis=0)
        return toward(offset, motion, self._period, near)

    @property
    def _arrival(self) -> float:
        motion = self._config.motion
        return max(motion.arrival_m, motion.arrival_sigmas * motion.sigma_m)

    def _report(self) -> CoverageReport:
        place = self._board.get(self._place) if self._place is not None else None
        settled = (self._mode is CoverageMode.WAITING and self._travel is None) or (
            self._mode is CoverageMode.HOLDING and (self._release is None or self._release.is_decided)
        )
        left = self._board.count(State.OPEN) + self._board.count(State.TAKEN)
        return CoverageReport(
            mode=self._mode,
            position=self._position,
            target=None if place is None else np.array(place.position),
            hops=-1 if self._rendezvous.hops == INFINITE else self._rendezvous.hops,
            searches=self._rendezvous.searches,
            places=len(self._board),
            is_done=self._solid is not None and settled and not left,
            is_leading=self._is_leading,
        )
