import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_msgs_py.assembly.boat_frames import BoatFrame, Move, Phase, decode_boat_frame, encode_boat_frame
from swarm_msgs_py.errors import FrameError

CELLS = st.tuples(st.integers(-1000, 1000), st.integers(-1000, 1000))
FRAMES = st.builds(
    BoatFrame,
    st.sampled_from(Phase),
    st.integers(0, 999),
    st.integers(0, 0xFFFF),
    st.integers(0, 999),
    CELLS,
    st.sampled_from(Move),
    st.booleans(),
    st.integers(0, 255),
    st.lists(CELLS, max_size=5).map(tuple),
)


@settings(max_examples=50, derandomize=True)
@given(FRAMES)
def test_a_frame_survives_the_air(frame: BoatFrame) -> None:
    assert decode_boat_frame(encode_boat_frame(frame)) == frame


@settings(max_examples=100, derandomize=True)
@given(st.binary(max_size=40))
def test_bytes_that_are_no_frame_are_refused_and_nothing_else(data: bytes) -> None:
    try:
        frame = decode_boat_frame(data)
    except FrameError:
        return
    assert encode_boat_frame(frame) == data


def test_a_shift_beyond_its_field_is_refused() -> None:
    with pytest.raises(FrameError):
        encode_boat_frame(BoatFrame(Phase.GO, 1, 1, 1, (40_000, 0)))
