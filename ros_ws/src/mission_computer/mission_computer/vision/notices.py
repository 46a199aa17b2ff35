"""What is told to the operator of things that come and go: once when they begin, once when they are over.

An image now and then proves nothing, in either direction. What every image of a moment shows is told, and so is what
most images of a longer window show; it is over when few do any more. The words may change while the matter stays.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field

MOMENT = 1e-9  # [s]; times are products of ticks and their duration
BEGINS, ENDS = 0.5, 0.25
"""Shares of the images of the window: told when more than the one show it, over when no more than the other do."""


@dataclass(frozen=True, slots=True)
class Finding:
    """Something that is not as it should be.

    Attributes
    ----------
    kind : str
        What is the matter. The same matter is not told again, even if other numbers belong to it.
    words : str
        What is said of it.
    """

    kind: str
    words: str


@dataclass(slots=True)
class _Record:
    """What was found of one subject: by time [s], since when in all images [s], and what is in force of it."""

    seen: deque[tuple[float, str]] = field(default_factory=deque)
    since: float | None = None
    told: str | None = None


class Notices:
    """Turns findings of single images into lines.

    Parameters
    ----------
    after_s : float
        What lasts so long without a gap is told [s].
    over_s : float
        Length of the window over which the rest is judged [s].
    """

    def __init__(self, after_s: float, over_s: float) -> None:
        self._after_s, self._over_s = after_s, over_s
        self._images: deque[float] = deque()
        self._records: dict[str, _Record] = {}

    def take(self, time: float, found: Mapping[str, Finding]) -> list[str]:
        """Take what one image shows; return what is new, in lines.

        Parameters
        ----------
        time : float
            At which it was taken [s]; it grows. Time in which nothing can be seen may be left out.
        found : mapping
            By subject; what is not in it is well.
        """
        self._images.append(time)
        start = time - self._over_s + MOMENT
        while self._images[0] < start:
            self._images.popleft()
        lines = []
        for subject in [*found, *(subject for subject in self._records if subject not in found)]:
            record, finding = self._records.setdefault(subject, _Record()), found.get(subject)
            line = self._judged(record, finding, time, start)
            if line:
                lines.append(f"{subject}: {line}")
            if record.told is None and not record.seen:
                del self._records[subject]
        return lines

    def _judged(self, record: _Record, finding: Finding | None, time: float, start: float) -> str:
        """Bring what is known of a subject up to date; return what is new of it."""
        if finding is None:
            record.since = None
        else:
            record.seen.append((time, finding.kind))
            record.since = time if record.since is None else record.since
        while record.seen and record.seen[0][0] < start:
            record.seen.popleft()
        share = len(record.seen) / len(self._images)
        if finding is None:
            if record.told is None or share > ENDS:
                return ""
            record.told = None
            return "well again"
        if record.told is None:
            is_long = record.since is not None and time - record.since >= self._after_s - MOMENT
            if not is_long and (share <= BEGINS or not self._is_full(time)):
                return ""
        elif finding.kind == record.told or share < 1.0 or any(kind != finding.kind for _, kind in record.seen):
            return ""  # another matter takes its place only when nothing else showed in the whole window
        record.told = finding.kind
        return finding.words

    def _is_full(self, time: float) -> bool:
        """Return whether there are images from all of the window, but for what is left of a moment at its beginning."""
        return time - self._images[0] >= self._over_s - self._after_s
