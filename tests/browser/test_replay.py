"""Episodes played in a real browser: every control, key and touch does what it says."""

from __future__ import annotations

import pytest

from browser.pages import replay_document
from jaxwalk.viewer import replay_page

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("replay") / "replay.html"
    replay_page(replay_document(), path, title="Replay")
    return path


@pytest.fixture
def opened(file, open_file):
    return open_file(file)


def clock(page):
    """The time shown [s]."""
    return float(page.text_content(".clock").split(" s")[0])


def pixels(page, selector=".stage canvas"):
    """A canvas, as text that changes with what is drawn."""
    return page.eval_on_selector(selector, "canvas => canvas.toDataURL()")


def test_it_opens_at_the_start_of_the_first_episode(opened):
    opened.wait_for_selector(".stage canvas")
    assert opened.text_content("figcaption") == "rash among always-go, scenario 7: collision after 4.0 s"
    assert clock(opened) == 0
    assert opened.eval_on_selector(".scrub", "scrub => Number(scrub.max)") == 4


def test_nobody_is_shut_out(opened, check_both_schemes):
    opened.wait_for_selector(".stage canvas")
    check_both_schemes(opened)


def test_a_moment_has_an_address(file, open_file):
    page = open_file(file, "#episode=217&t=2.3&driver=careful")
    page.wait_for_selector(".stage canvas")
    assert clock(page) == 2.3
    assert page.text_content("figcaption").startswith("careful among always-go, scenario 217")
    assert "t=2.3" in page.get_attribute(".link", "href")
    page.keyboard.press("ArrowRight")
    page.wait_for_function("location.hash.includes('t=2.4')")
    page.evaluate("location.hash = '#episode=9&t=1'")
    page.wait_for_function("document.querySelector('figcaption').textContent.includes('scenario 9')")
    assert clock(page) == 1


def test_an_address_of_nothing_is_said(file, open_file):
    page = open_file(file, "#episode=218&t=2.3")
    page.wait_for_selector("text=This page doesn't have the episode of the link.")
    assert page.text_content("figcaption").startswith("rash among always-go, scenario 7")


def test_play_runs_to_the_end_and_pause_stops(opened):
    opened.wait_for_selector(".stage canvas")
    opened.select_option("[name=rate]", "4")
    opened.click("[data-do=toggle]")
    opened.wait_for_function("document.querySelector('[data-do=toggle]').textContent.includes('Play')")
    assert clock(opened) == 4
    opened.click("[data-do=toggle]")
    opened.wait_for_timeout(150)
    opened.keyboard.press("k")
    stopped = clock(opened)
    assert 0 < stopped < 4
    opened.wait_for_timeout(150)
    assert clock(opened) == stopped


def test_steps_events_and_the_time_line(opened):
    opened.wait_for_selector(".stage canvas")
    opened.click("[data-do=forward]")
    opened.click("[data-do=forward]")
    opened.click("[data-do=back]")
    assert clock(opened) == 0.1
    opened.click("[data-do=event]")
    assert clock(opened) == 2.2
    opened.click(".events li:last-child button")
    assert clock(opened) == 4
    assert "collision with pedestrian 1" in opened.text_content(".events li:last-child")
    opened.eval_on_selector(".scrub", "s => { s.value = 1.5; s.dispatchEvent(new Event('input')); }")
    assert clock(opened) == 1.5
    box = opened.locator(".strips").bounding_box()
    opened.mouse.click(box["x"] + box["width"] / 2, box["y"] + 40)
    assert clock(opened) == pytest.approx(2.0, abs=0.2)


def test_keys(opened):
    opened.wait_for_selector(".stage canvas")
    for key, time in (("End", 4.0), ("Shift+ArrowLeft", 3.0), ("ArrowLeft", 2.9), ("Home", 0.0), ("e", 2.2)):
        opened.keyboard.press(key)
        assert clock(opened) == time, key
    for key, name in (("h", "hidden"), ("p", "plans"), ("r", "rings"), ("l", "trails"), ("f", "follow")):
        before = opened.is_checked(f"[name={name}]")
        opened.keyboard.press(key)
        assert opened.is_checked(f"[name={name}]") != before, key
    opened.keyboard.press("+")
    assert opened.input_value("[name=rate]") == "2"
    opened.keyboard.press("-")
    assert opened.input_value("[name=rate]") == "1"


@pytest.mark.parametrize("name", ["hidden", "plans", "rings", "trails", "follow"])
def test_every_switch_changes_the_picture(opened, name):
    opened.wait_for_selector(".stage canvas")
    opened.keyboard.press("e")
    before = pixels(opened)
    opened.click(f"[name={name}]")
    assert pixels(opened) != before
    opened.click(f"[name={name}]")
    assert pixels(opened) == before


def test_the_picture_is_told_in_words(opened):
    opened.wait_for_selector(".stage canvas")
    opened.keyboard.press("End")
    said = opened.get_attribute(".stage canvas", "aria-label")
    assert said.startswith("At 4.0 s the car drives 5.0 m/s. Within 12 metres: pedestrian 1")
    assert "jaywalking" in said


STRIPS = """
window.strips = [];
const before = (name, note) => {
  const prototype = CanvasRenderingContext2D.prototype, drawn = prototype[name];
  prototype[name] = function (...given) {
    if (this.canvas.className === "strips") note(...given);
    return drawn.apply(this, given);
  };
};
before("clearRect", () => (strips = []));
before("beginPath", () => strips.push([]));
before("lineTo", (x, y) => strips.at(-1).push(y));
before("fillText", (words) => strips.push(words));
"""
"""Writes down what the strips draw: texts, and the heights of each path."""


def test_command_and_acceleration_are_two_strips(page, file, open_file):
    """The careful car is told to brake for a second, but its speed stays the same (in this scene)."""
    page.add_init_script(STRIPS)
    open_file(file, "#episode=7&driver=careful").wait_for_selector(".stage canvas")
    drawn = page.evaluate("strips")
    titles = [x for x in drawn if isinstance(x, str) and x.endswith("]")]
    assert titles == [
        "speed [m/s]", "acceleration that the driver commands [m/s²]", "acceleration of the car [m/s²]",
    ]  # fmt: skip
    _, command, acceleration = (x for x in drawn if isinstance(x, list) and len(x) == 51)
    assert len(set(command)) == 2
    assert len(set(acceleration)) == 1


def test_long_names_fit_a_phone(browser, tmp_path):
    path = tmp_path / "long.html"
    document = replay_document()
    for entry in document["episodes"]:
        entry["driver"] += "-of-a-name-as-long-as-a-path/that/somebody/would/really/use.safetensors"
    replay_page(document, path, title="jaxwalk: " + document["episodes"][0]["driver"] + " among learned")
    context = browser.new_context(viewport={"width": 400, "height": 800})
    page = context.new_page()
    page.goto(path.as_uri())
    page.wait_for_selector(".stage canvas")
    assert page.evaluate("document.documentElement.scrollWidth") <= 400
    context.close()


def test_the_same_scenario_side_by_side(opened):
    opened.select_option("[name=beside]", label="careful among always-go")
    opened.wait_for_function("document.querySelectorAll('.stage').length === 2")
    captions = opened.locator("figcaption").all_text_contents()
    assert [caption.split(" among")[0] for caption in captions] == ["rash", "careful"]
    assert opened.eval_on_selector(".scrub", "scrub => Number(scrub.max)") == 5
    opened.keyboard.press("End")
    assert opened.text_content(".clock").strip().endswith("5.0 m/s | 2.0 m/s")
    assert opened.get_attribute(".stage:first-child canvas", "aria-label").startswith("It ended at 4.0 s")
    address = opened.get_attribute(".link", "href")
    opened.select_option("[name=beside]", label="nothing")
    opened.wait_for_function("document.querySelectorAll('.stage').length === 1")
    opened.evaluate("address => { location.hash = address; }", address)
    opened.wait_for_function("document.querySelectorAll('.stage').length === 2")


def test_another_episode_can_be_chosen(opened):
    opened.wait_for_selector(".stage canvas")
    opened.select_option("[name=episode]", index=4)
    opened.wait_for_function("document.querySelector('figcaption').textContent.startsWith('careful')")
    assert opened.text_content("figcaption").endswith("scenario 9: goal reached after 5.0 s")


def test_the_map_can_be_dragged_and_zoomed(opened):
    opened.wait_for_selector(".stage canvas")
    whole = pixels(opened)
    box = opened.locator(".stage canvas").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    opened.mouse.move(x, y)
    opened.mouse.wheel(0, -400)
    opened.wait_for_timeout(50)
    assert pixels(opened) == whole  # without Ctrl, the page scrolls
    opened.keyboard.down("Control")
    opened.mouse.wheel(0, -400)
    opened.keyboard.up("Control")
    opened.wait_for_timeout(50)
    near = pixels(opened)
    assert near != whole
    opened.mouse.down()
    opened.mouse.move(x + 80, y + 40, steps=3)
    opened.mouse.up()
    assert pixels(opened) != near
    opened.click("[data-do=whole]")
    assert pixels(opened) == whole


def test_two_fingers_zoom_on_a_phone(browser, file):
    context = browser.new_context(viewport={"width": 390, "height": 800}, has_touch=True, is_mobile=True)
    page = context.new_page()
    page.goto(file.as_uri())
    page.wait_for_selector(".stage canvas")
    whole = pixels(page)
    page.eval_on_selector(
        ".stage canvas",
        """canvas => {
          const send = (type, id, x) => canvas.dispatchEvent(new PointerEvent(type, {
            pointerId: id, clientX: x, clientY: 200, bubbles: true }));
          canvas.setPointerCapture = () => {};
          send("pointerdown", 1, 150); send("pointerdown", 2, 200); send("pointermove", 2, 320);
        }""",
    )
    assert pixels(page) != whole
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    context.close()


def test_drawing_keeps_up_with_the_screen(opened):
    opened.wait_for_selector(".stage canvas")
    drawn = opened.evaluate(
        """() => new Promise((done) => {
          let draws = 0;
          const clear = CanvasRenderingContext2D.prototype.clearRect; // once for each drawing of the strips
          CanvasRenderingContext2D.prototype.clearRect = function (...where) {
            draws++;
            clear.apply(this, where);
          };
          document.querySelector("[data-do=toggle]").click();
          setTimeout(() => done(draws), 1000);
        })"""
    )
    assert drawn > 5  # how many a second is the machine's; a stopped picture is ours
