"""The swarm as a table in the terminal while a run goes on: what each robot does, and how well it gets on."""

from __future__ import annotations

from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from bringup.engine import TickRecord
from bringup.scene import STYLES, WELL, RobotView, Scene, Scenes
from swarm_msgs_py.types import robot_name

MARGIN_LINES = 6  # of the terminal, for the live line, the head of the table and alerts


class Dashboard:
    """Keeps what it needs to show the swarm as it was in the last tick.

    Parameters
    ----------
    scenes : Scenes
        Of the run that is to be shown.
    """

    def __init__(self, scenes: Scenes) -> None:
        self._scenes = scenes
        self._scene: Scene | None = None

    def take(self, record: TickRecord[Any, Any]) -> None:
        """Take in one tick."""
        self._scene = self._scenes.take(record)

    def render(self, head: Text, height: int) -> RenderableType:
        """Return a table below a head line, of no more lines than the terminal has.

        Where there are more robots than lines, those are left out that need the least attention.
        """
        robots = self._scene.robots if self._scene is not None else ()
        room = max(1, height - MARGIN_LINES)
        ranked = sorted(robots, key=lambda view: (*view.attention, view.robot))
        shown, hidden = ranked[:room], ranked[room:]
        table = Table(box=None, padding=(0, 2, 0, 0), header_style="bold")
        for title in ("robot", "mode", *self._scenes.columns):
            table.add_column(Text(title), justify="right" if "[" in title or title == "links" else "left")
        for view in sorted(shown, key=lambda shown_view: shown_view.robot):
            table.add_row(*_cells(view))
        how = ", which are well" if all(view.attention[0] == WELL for view in hidden) else ""
        return Group(head, table, *([Text(f"and {len(hidden)} more{how}", style="dim")] if hidden else []))


def _cells(view: RobotView) -> list[Text | str]:
    """Return the cells of a robot's line; of one that is gone, only what it is."""
    facts = view.facts if any(fact is not None for fact in view.facts) else ()
    return [robot_name(view.robot), Text(view.state, style=STYLES[view.color]), *map(_text, facts)]


def _text(fact: str | float | None) -> str:
    if fact is None:
        return "-"
    return f"{fact:.2f}" if isinstance(fact, float) else str(fact)
