"""Truth plus named random streams -> what robots measure."""
