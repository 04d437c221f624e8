"""Options that are repeated, renamed, or too large: nothing that was asked for is lost in silence."""

from __future__ import annotations

import pytest

from jaxwalk.cli import main, options
from jaxwalk.cli.commands import COMMANDS, parse

HUGE = str(10**21)
COUNTS = {
    "evaluate": "evaluate --driver random --episodes",
    "counterfactuals": "evaluate --driver random --counterfactuals",
    "tracks": "tracks --driver random --episodes",
    "report": "report random --episodes",
    "report counterfactuals": "report random --counterfactuals",
    "incidents": "report random --incidents",
    "reproduce": "reproduce --out r --episodes",
    "reproduce updates": "reproduce --out r --updates",
    "reproduce seeds": "reproduce --out r --seeds",
    "reproduce minutes": "reproduce --out r --minutes",
    "intent": "hidden-intent --out r --episodes",
    "intent seeds": "hidden-intent --out r --seeds",
    "co-training": "co-training --out r --seeds",
    "frontier": "frontier --out r --episodes",
    "search": "search random --simulations",
    "search particles": "search random --particles",
    "train": "train --run r --updates",
    "train minutes": "train --run r --minutes",
    "train environments": "train --run r --environments",
    "train steps": "train --run r --steps",
    "train rows": "train --run r --chunk-rows",
    "train checkpoints": "train --run r --checkpoint-minutes",
    "bench environments": "bench --environments",
    "bench training environments": "bench --training-environments",
    "bench pedestrians": "bench --pedestrians",
    "bench rows": "bench --chunk-rows",
    "bench seconds": "bench --seconds",
    "driver seconds": "evaluate --driver random --driver-seconds",
    "play seconds": "play --driver random --driver-seconds",
    "scenario": "play --driver random --scenario",
}
"""Options that count, each to be followed by a number."""


def test_values_of_a_repeated_option_are_all_kept():
    asked = parse(
        [
            "evaluate",
            "--driver",
            "a",
            "--seed",
            "3",
            "--driver",
            "b",
            "c",
            "--map",
            "x",
            "--driver=d",
            "--map",
            "y",
            "--json",
        ]
    )
    assert asked == options.Evaluate(driver=("a", "b", "c", "d"), seed=3, map=("x", "y"), json=True)
    asked = parse(["report", "a", "b", "--pedestrians", "p", "--episodes", "4", "--pedestrians", "q"])
    assert asked == options.Report(runs=("a", "b"), pedestrians=("p", "q"), episodes=4)
    assert parse(["train", "--map", "a", "--run", "r", "--map", "b"]).map == ("a", "b")


OTHERS = {
    "observations": ("--role", "driver"), "measure": ("--frame-rate", "2"), "train": ("--recipe", "x"),
    "map new": ("--length", "90"),
}  # fmt: skip
"""Options with one value of commands without --out."""


@pytest.mark.parametrize("command", [command.name for command in COMMANDS if command.name != "map check"])
def test_an_option_with_one_value_may_not_be_repeated(command, capsys):
    """Every command has one, but `map check`, which has no options."""
    option, value = OTHERS.get(command, ("--out", "x"))
    assert main([command, option, value, option, value]) == 2
    assert capsys.readouterr().err == f"jaxwalk: {option}: is given twice; give it once\n"


def test_another_spelling_is_the_same_option(capsys):
    assert main(["train", "--run", "r", "--learning-rate", "0.1", "--learning_rate=0.2"]) == 2
    assert capsys.readouterr().err == "jaxwalk: --learning_rate: is given twice; give it once\n"


@pytest.mark.parametrize(
    ("old", "new"), [("--sample-driver", "--driver-acts sample"), ("--pedestrian-mode", "--pedestrians-act mode")]
)
def test_an_option_of_an_earlier_version_says_what_to_write(old, new, capsys):
    assert main(["evaluate", "--driver", "random", old]) == 2
    assert capsys.readouterr().err == f"jaxwalk: {old}: is written {new} now\n"


@pytest.mark.parametrize("name", COUNTS)
def test_a_count_has_a_largest_value(name, place, capsys, monkeypatch):
    monkeypatch.setattr("jaxwalk.cli.commands.try_jax", lambda set_here: None)  # a process of its own for each
    assert main([*COUNTS[name].split(), HUGE]) == 2
    err = capsys.readouterr().err
    assert " must " in err and err.count("\n") == 1
    assert not any(place.iterdir())


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("train --run r --learning-rate inf", "learning_rate must be a finite number above 0, not inf"),
        ("train --run r --jaywalk-multiplier inf", "jaywalk_multiplier must be a finite number of 0 or more, not inf"),
        (
            "evaluate --driver random --jaywalk-multiplier inf",
            "jaywalk_multiplier must be a finite number of 0 or more",
        ),
        ("play --driver random --time inf", "--time must be a finite number of 0 or more, not inf"),
    ],
)
def test_infinity_is_refused_in_words(line, message, capsys):
    assert main(line.split()) == 2
    assert message in capsys.readouterr().err
