"""The computer of one boat: takes orders from the mission computer, steers, and tells how far it is."""

from __future__ import annotations

import numpy as np

from swarm_agent.assembly.navigator import Navigator
from swarm_agent.assembly.skipper import Skipper
from swarm_agent.assembly.steering import SkipperConfig, SkipperInputs, SkipperOutputs
from swarm_msgs_py.assembly.orders import Order, PlanOrders, TimedOrders
from swarm_msgs_py.assembly.progress_frames import ProgressFrame


class BoatComputer:
    """One boat, with or without a target.

    Parameters
    ----------
    boat : int
    config : SkipperConfig
    period_s : float
        Control period [s].
    """

    def __init__(self, boat: int, config: SkipperConfig, period_s: float) -> None:
        self._boat = boat
        self._config = config
        self._period_s = period_s
        self._epoch = 0
        self._skipper: Skipper | Navigator | None = None
        self._is_halting = False

    @property
    def steps(self) -> int:
        """Steps of the plan that it follows, 0 without one."""
        return self._skipper.steps if self._skipper else 0

    def step(self, inputs: SkipperInputs, order: Order | None) -> SkipperOutputs:
        """Act in one tick.

        Parameters
        ----------
        inputs : SkipperInputs
        order : Order or None
            Last order that was heard; it may be heard again and again.
        """
        if order is not None:
            self._obey(order, inputs)
        if self._skipper is not None:
            return self._skipper.step(inputs)
        frame = ProgressFrame(self._boat, self._epoch, 0, is_halted=self._is_halting)
        return SkipperOutputs(np.zeros(3), frame, is_done=True, goal=inputs.reference[:2])

    def _obey(self, order: Order, inputs: SkipperInputs) -> None:
        if order.epoch < self._epoch:
            return
        if order.plan is None:
            self._is_halting |= order.epoch == self._epoch
            if self._skipper is not None and order.epoch == self._epoch:
                self._skipper.is_halting = True
        elif order.epoch > self._epoch:
            self._epoch, self._is_halting = order.epoch, False
            self._skipper = self._steersman(order.plan, float(inputs.reference[2]))

    def _steersman(self, plan: PlanOrders, heading: float) -> Skipper | Navigator | None:
        if self._boat not in plan.dispatch.boats:
            return None
        if isinstance(plan, TimedOrders):
            return Skipper(self._boat, plan, self._config, self._period_s, heading)
        return Navigator(self._boat, plan, self._config, self._period_s, heading)
