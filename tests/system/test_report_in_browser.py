"""The report as a person sees it: loaded from disk into a real Chromium, played, scrubbed, clicked."""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from chromium import browser
from PIL import Image
from playwright.sync_api import Browser, Page
from recorded_runs import made_run, run_in_space, run_of_points, run_of_shapes, run_on_lattice
from run_folders import metrics_of, run_in_process

from reports.page import report_page
from reports.run_record import RunRecord

pytestmark = pytest.mark.needs_browser

Open = Callable[[Path], Page]
PAINTED = "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
"""Resolves when everything that was asked for has been drawn."""


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    with browser() as found:
        yield found


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a finished run of four robots."""
    folder = tmp_path_factory.mktemp("smoke") / "run"
    assert run_in_process(folder, "--scenario", "smoke-4") == 0
    return folder


@pytest.fixture
def open_report(chromium: Browser) -> Iterator[Open]:
    """Open report files; fail if one of them complains, or asks for anything but itself."""
    context = chromium.new_context(viewport={"width": 1300, "height": 900}, offline=True)
    complaints: list[str] = []

    def show(path: Path) -> Page:
        page = context.new_page()
        page.on("console", lambda message: complaints.append(message.text))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("request", lambda request: complaints.append(request.url) if request.url != path.as_uri() else None)
        page.goto(path.as_uri())
        page.wait_for_function("() => window.swarmReport !== undefined")
        page.evaluate(PAINTED)
        return page

    yield show
    context.close()
    assert complaints == []


@pytest.fixture
def open_run(open_report: Open, tmp_path: Path) -> Callable[[RunRecord], Page]:
    """Open the report of a made-up run."""

    def show(record: RunRecord) -> Page:
        path = tmp_path / "report.html"
        path.write_bytes(report_page(record))
        return open_report(path)

    return show


def scrub(page: Page, time: float) -> None:
    """Move the scrubber, as a hand does."""
    page.locator("#scrubber").evaluate(
        "(slider, time) => { slider.value = time; slider.dispatchEvent(new Event('input', { bubbles: true })); }", time
    )
    page.evaluate(PAINTED)


def picture(page: Page) -> np.ndarray:
    """Return what the canvas of the replay shows, (h, w, 3)."""
    image = Image.open(io.BytesIO(page.locator("#arena").screenshot())).convert("RGB")
    return np.asarray(image).astype(np.int64)


def only_layers(page: Page, *names: str) -> None:
    for box in page.locator("#layers input").all():
        box.set_checked(box.get_attribute("data-layer") in names)
    page.evaluate(PAINTED)


def pixels_of(page: Page, time: float) -> np.ndarray:
    """Return where on the canvas the robots truly are at a time, (n, 2)."""
    places = page.evaluate(
        """(time) => {
            const { replay, view } = window.swarmReport, frame = replay.frameAt(time);
            return replay.data.names.map((_, robot) => view.pixel(replay.point("position", frame, robot)));
        }""",
        time,
    )
    return np.array(places)


def test_a_run_leaves_a_report_with_its_metrics_and_scenario(demo: Path, open_report: Open) -> None:
    page = open_report(demo / "report.html")

    rows = page.locator(".metrics tr").all_inner_texts()
    named = {row.split("\t")[0] for row in rows}
    assert named == set(metrics_of(demo))
    assert page.locator(".verdict").inner_text() == "achieved"
    assert metrics_of(demo)["reason"] in page.locator("header").inner_text()
    assert page.locator("#scenario").text_content() == (demo / "scenario.yaml").read_text()


def test_the_scrubber_moves_the_robots_to_where_they_were(demo: Path, open_report: Open) -> None:
    page = open_report(demo / "report.html")
    with np.load(demo / "trajectories.npz") as arrays:
        time, position = arrays["time"], arrays["position"]
    page.locator("#fit-shape").click()
    only_layers(page, "circles")

    seen = []
    for share in (0.3, 1.0):
        scrub(page, share * time[-1])
        shown = page.evaluate(
            """() => { const { replay, player } = window.swarmReport, frame = replay.frameAt(player.time);
                return replay.data.names.map((_, robot) => replay.point("position", frame, robot)); }"""
        )
        row = int(np.searchsorted(time, share * time[-1]))
        assert np.array(shown) == pytest.approx(position[row], abs=0.1)  # between ticks, motion is drawn straight
        seen.append(picture(page))

    assert page.locator("#clock").inner_text() == f"{time[-1]:.1f} s"
    assert (seen[0] != seen[1]).any(axis=-1).sum() > 200
    for x, y in pixels_of(page, time[-1]):
        column, row = round(x), round(y)
        around = seen[1][row - 8 : row + 9, column - 8 : column + 9].reshape(-1, 3)
        assert (np.ptp(around, axis=-1) > 100).mean() > 0.2  # a circle in a strong color, with a white nose


def test_it_plays_faster_when_told_and_stands_when_paused(open_run: Callable[[RunRecord], Page]) -> None:
    page = open_run(made_run(ticks=400))
    time_of = "() => window.swarmReport.player.time"

    page.locator("#speed").select_option("10")
    page.locator("#play").click()
    page.wait_for_function(f"() => ({time_of})() > 5")
    assert "pause" in page.locator("#play").inner_text()
    page.locator("#play").click()
    stood = page.evaluate(time_of)
    page.evaluate(PAINTED)
    assert page.evaluate(time_of) == stood < 200.0
    page.locator("#forward").click()
    assert page.evaluate(time_of) == pytest.approx((stood // 0.5 + 1) * 0.5)
    page.locator("#back").click()
    assert page.evaluate(time_of) == pytest.approx(stood // 0.5 * 0.5)


LAYERS = {
    "shape": (0xF0, 0xE9, 0xDA),
    "obstacles": (0xB8, 0xB8, 0xB8),
    "goals": (0x1C, 0x1C, 0x1C),
    "estimates": (0xB0, 0x20, 0x8F),
    "links": (0x4A, 0x78, 0xA8),
    "paths": (0x00, 0x72, 0xB2),
    "trails": (0x00, 0x72, 0xB2),
}
"""What can be shown, and in which color."""


def test_each_layer_shows_what_it_is_named_after(open_run: Callable[[RunRecord], Page]) -> None:
    page = open_run(made_run())
    scrub(page, 4.0)
    only_layers(page)
    without, background = picture(page), np.array([246, 246, 244])

    for layer, color in LAYERS.items():
        only_layers(page, layer)
        shown = picture(page)
        changed = (shown != without).any(axis=-1)
        # Thin and faint lines are blends of their color and what is below: along that line, away from the background.
        toward = np.array(color) - background
        shares = (shown[changed] - background) @ toward / (toward @ toward)
        assert changed.sum() > 20, layer
        assert (shares > 0.01).mean() > 0.9, layer


def test_lost_and_dead_robots_are_marked_and_named(open_run: Callable[[RunRecord], Page]) -> None:
    page = open_run(made_run())
    only_layers(page, "circles")
    orange, red = np.array([0xE0, 0x60, 0x00]), np.array([0xC0, 0x00, 0x00])

    counts = {}
    for time in (0.0, 1.0, 2.0, 8.0):
        scrub(page, time)
        shown = picture(page)
        counts[time] = [int((np.abs(shown - color).sum(axis=-1) < 60).sum()) for color in (orange, red)]
        counts[time].append(page.locator("#state").inner_text())

    assert counts[0.0][:2] == [0, 0]
    assert counts[1.0][0] > 5
    assert "lost" in counts[1.0][2]
    assert counts[2.0][0] > counts[1.0][0]  # a full ring instead of a dashed one
    assert "returning home" in counts[2.0][2]
    assert counts[8.0][1] > 5
    assert "off\t1" in counts[8.0][2]
    assert "the last robot died" in page.locator("#alerts").inner_text()


def test_a_click_on_a_robot_tells_its_state(open_run: Callable[[RunRecord], Page]) -> None:
    page = open_run(made_run())
    scrub(page, 2.0)
    x, y = pixels_of(page, 2.0)[1]

    page.locator("#arena").click(position={"x": x, "y": y})
    page.evaluate(PAINTED)
    assert page.locator("#state-title").inner_text() == "r01"
    state = page.locator("#state").inner_text()
    assert "traveling" in state
    assert "r00 r02" in state
    assert "number 1" in state


def test_dragging_and_the_wheel_move_the_picture(open_run: Callable[[RunRecord], Page]) -> None:
    page = open_run(made_run())
    box = page.locator("#arena").bounding_box()
    assert box is not None
    before = pixels_of(page, 0.0)
    page.mouse.move(box["x"] + 300, box["y"] + 300)
    page.mouse.down()
    page.mouse.move(box["x"] + 340, box["y"] + 310)
    page.mouse.up()
    after = pixels_of(page, 0.0)

    assert after - before == pytest.approx(np.tile([40.0, 10.0], (len(before), 1)), abs=1.0)
    page.mouse.wheel(0, -300)
    page.wait_for_function("(x) => Math.abs(window.swarmReport.view.pixel([0, 0])[0] - x) > 1", arg=float(after[0, 0]))
    spread = np.ptp(pixels_of(page, 0.0), axis=0) / np.ptp(after, axis=0)
    assert spread == pytest.approx(np.exp(0.45), rel=0.05)


def test_charts_are_drawn_and_take_the_replay_to_where_they_are_clicked(demo: Path, open_report: Open) -> None:
    page = open_report(demo / "report.html")

    names = [box.get_attribute("data-chart") for box in page.locator("#charts figure").all()]
    assert {"goal-distance", "localization", "modes", "displacement", "clearance", "connectivity", "traffic"} <= {
        *names
    }
    for box in page.locator("#charts figure").all():
        image = np.asarray(Image.open(io.BytesIO(box.screenshot())).convert("RGB")).astype(np.int64)
        assert (np.ptp(image, axis=-1) > 60).sum() > 50  # a line in color
    over = page.locator("#charts figure .u-over").first
    size = over.bounding_box()
    assert size is not None
    over.click(position={"x": size["width"] / 2, "y": 20})
    time, end = page.evaluate("() => [window.swarmReport.player.time, window.swarmReport.replay.duration]")
    assert time == pytest.approx(end / 2, rel=0.05)


def test_a_run_in_space_can_be_turned(open_run: Callable[[RunRecord], Page]) -> None:
    page = open_run(run_in_space())
    scrub(page, 2.0)
    before = picture(page)
    box = page.locator("#arena").bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 300, box["y"] + 300)
    page.mouse.down()
    page.mouse.move(box["x"] + 420, box["y"] + 300)
    page.mouse.up()
    page.evaluate(PAINTED)

    assert (np.ptp(before, axis=-1) > 60).sum() > 200  # robots
    assert (picture(page) != before).any(axis=-1).sum() > 500
    assert page.evaluate("() => window.swarmReport.view.constructor === Swarm.views.space")


def test_a_run_of_which_only_the_motion_is_stored_is_shown_with_its_surface_and_links(
    open_run: Callable[[RunRecord], Page],
) -> None:
    page = open_run(run_of_points())
    scrub(page, 2.0)
    shown = {}
    for layer in ("circles", "shape", "links"):
        only_layers(page)
        without = picture(page)
        only_layers(page, layer)
        shown[layer] = int((picture(page) != without).any(axis=-1).sum())

    assert min(shown.values()) > 100, shown
    pairs = page.evaluate(
        """() => { const { replay, view } = window.swarmReport, points = replay.data.names.map((_, robot) =>
            replay.point("position", 0, robot)); return view.pairs(0, points).length; }"""
    )
    start = run_of_points().arrays["position"][0]
    gaps = np.linalg.norm(start[:, None] - start[None], axis=-1)
    assert pairs == int((np.triu(gaps <= 4.0, 1)).sum())


def test_docked_boats_are_squares_with_a_bar_between_them(open_run: Callable[[RunRecord], Page]) -> None:
    page = open_run(run_on_lattice())
    green = np.array([0x00, 0x7A, 0x4D])

    bars = []
    for time in (1.0, 5.0, 9.0):
        scrub(page, time)
        only_layers(page, "circles", "shape")
        bars.append(int((np.abs(picture(page) - green).sum(axis=-1) < 40).sum()))
    assert bars[0] < bars[1] < bars[2]


@pytest.mark.parametrize("ticks", [0, 1])
def test_the_report_of_a_run_that_hardly_began_opens(ticks: int, tmp_path: Path, open_report: Open) -> None:
    folder = tmp_path / "run"
    assert run_in_process(folder, "--scenario", "smoke-4", "--set", "duration_s=0.5") == 1
    record = RunRecord.load(folder)
    if not ticks:
        empty = {name: values[:0] for name, values in record.arrays.items() if len(values.shape) and len(values) == 1}
        kept = {**record.arrays, **empty, "time": record.arrays["time"][:0], "position": record.arrays["position"][:0]}
        record = replace(record, arrays=kept)
    path = tmp_path / "report.html"
    path.write_bytes(report_page(record))

    page = open_report(path)
    assert page.locator(".verdict").inner_text() == "not achieved"


def test_names_and_texts_of_a_run_are_shown_and_never_run(open_run: Callable[[RunRecord], Page]) -> None:
    evil = "</script><script>window.evil = 1</script><img src=x onerror='window.evil = 1'>{{data}}"
    record = made_run(alert_text=np.array([evil]))
    page = open_run(replace(record, metrics={**record.metrics, "scenario": evil, "reason": evil}, scenario=evil))

    assert page.evaluate("() => window.evil") is None
    assert page.locator("#scenario").text_content() == evil
    assert evil in page.locator("#alerts").inner_text()


def test_the_page_forbids_itself_to_load_anything(open_run: Callable[[RunRecord], Page]) -> None:
    page = open_run(made_run())
    policy = page.locator("meta[http-equiv='Content-Security-Policy']").get_attribute("content")

    assert policy is not None
    assert policy.startswith("default-src 'none'")
    data: dict[str, Any] = json.loads(page.locator("#run").text_content() or "")
    assert data["view"] == "plane"


def test_a_shape_that_moves_and_becomes_another_one_is_shown_where_it_is(open_run: Callable[[RunRecord], Page]) -> None:
    run = run_of_shapes()
    page = open_run(run)

    def middle(frame: float) -> list[float]:
        script = """(frame) => { const places = window.swarmReport.view.surfaceAt(frame);
            return [0, 1, 2].map((axis) => places.reduce((sum, place) => sum + place[axis], 0) / places.length); }"""
        return page.evaluate(script, frame)  # type: ignore[no-any-return]

    surfaces, shift = run.arrays["surfaces"], run.arrays["surface_shift"]
    assert middle(2) == pytest.approx(surfaces[0].mean(axis=0) + shift[2], abs=0.02)
    assert middle(2.5) == pytest.approx(surfaces[0].mean(axis=0) + (shift[2] + shift[3]) / 2.0, abs=0.02)
    assert middle(8) == pytest.approx(surfaces[1].mean(axis=0) + shift[8], abs=0.02)
