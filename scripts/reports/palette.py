"""Colors of pictures, the same in all of them."""

from __future__ import annotations

TYPE_COLORS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#D55E00", "#56B4E9")  # Okabe-Ito: safe for color blindness
SHAPE_FILL, SHAPE_EDGE, WALL_FILL, WALL_EDGE, DEAD = "#F0E9DA", "#7A6A4F", "#B8B8B8", "#555555", "#C00000"
LINK, LOST, DEAD_FILL = "#4A78A8", "#E06000", "#D9D9D9"
