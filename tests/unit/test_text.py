"""Texts from outside as messages show them: one line, no control characters, not too long, whatever they are."""

import numpy as np

from parisph.base.text import clipped, is_plain, listed, named, of_error, plain, shown


class Rude:
    def __repr__(self):
        raise ZeroDivisionError


class Mute(Exception):
    def __str__(self):
        raise ZeroDivisionError


def test_any_value_is_shown_on_a_short_plain_line():
    for value in (
        "x" * 1000, "a\nb" * 50, (1.0,) * 10**5, [[[[[1]]]]] * 9, {"a" * 100: "b" * 100}, 10**5000, b"\0" * 1000,
        Rude(), object(), "\x1b[31m", "\ud800", "\u2028", None, 1.5, np.arange(1000.0),
    ):
        text = shown(value)
        assert 0 < len(text) <= 80 and is_plain(text)


def test_short_values_are_shown_as_they_are():
    assert [shown(value) for value in ("a", 0.05, (0.0, "x"), None, "it's")] == ["'a'", "0.05", "(0.0, 'x')",
                                                                                 "None", '"it\'s"']
    assert named("runs/été") == "runs/été" and named("a\nb\x1b") == "a\\nb\\x1b"


def test_clipping_keeps_both_ends():
    text = "beginning" + "x" * 500 + "end"
    assert (clipped(text, 60).startswith("beginning") and clipped(text, 60).endswith("end")
            and len(clipped(text, 60)) == 60)
    assert clipped("short") == "short"


def test_control_characters_become_escapes():
    assert plain("a\tb\r\x07\u2029\udcff") == "a\\tb\\r\\x07\\u2029\\udcff" and plain("Größe 水") == "Größe 水"


def test_the_message_of_an_error_is_one_line():
    assert of_error(ValueError("a\nb")) == "a b" and len(of_error(ValueError("x" * 9999))) == 300
    assert of_error(Mute()) == "its message cannot be shown"


class Ending(Exception):
    def __repr__(self):
        raise SystemExit

    __str__ = __repr__


def test_an_object_that_ends_the_program_does_not_when_it_is_shown():
    assert shown(Ending()) == "<Ending>" and of_error(Ending()) == "its message cannot be shown"


def test_a_list_is_never_cut_in_the_middle_of_a_name():
    names = ["alpha", "beta", "gamma"]
    assert listed(names, 18) == "alpha, beta, gamma" and listed(names, 17) == "alpha and 2 more" and listed([], 9) == ""
    assert listed(names * 2, 24) == "alpha, beta and 4 more"
    assert len(listed(["x" * 1000], 80)) == 80
