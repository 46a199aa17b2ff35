"""How long to wait for news: counts the time that was spent waiting, not the time that has passed."""

from __future__ import annotations


class Patience:
    """Runs out when waiting has brought no news for long enough.

    Time in which nobody waited (the reader of the records was busy, the process was suspended) does not count: it says
    nothing about those who are waited for.

    Parameters
    ----------
    limit_s : float
        Longest wait without news [s].
    """

    def __init__(self, limit_s: float) -> None:
        self.limit_s = limit_s
        self._waited_s = 0.0

    def is_out(self, waited_s: float, *, has_news: bool) -> bool:
        """Take in one wait; return whether it was one too many. Then, and after news, counting begins anew."""
        self._waited_s = 0.0 if has_news else self._waited_s + waited_s
        if self._waited_s < self.limit_s:
            return False
        self._waited_s = 0.0
        return True
