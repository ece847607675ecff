"""The words of a column's name, and the unit that stands among them."""

import re
from pathlib import Path

from sym2real.files import read_toml
from sym2real.logs.units import UNITS

TABLES = read_toml(Path(__file__).with_name("words.toml"), "words in names of columns")
# What a word says → the words that say it; a word for a unit → the unit.
WORDS = {meaning: frozenset(words) for meaning, words in TABLES["words"].items()}
UNIT_WORDS: dict[str, str] = {word: unit for unit, words in TABLES["units"].items() for word in words}
OF_TIME_ALONE = [[word] for word, unit in UNIT_WORDS.items() if UNITS[unit][0] == "s"]
WRITTEN_UNITS = {"°": "deg", "°/s": "deg/s", "µs": "us", "μs": "us", "m/s2": "m/s^2", "m/s²": "m/s^2", "Nm": "N m"}

# Units that a name ends with in several words.
TAILS: dict[tuple[str, ...], str] = {
    ("m", "s", "2"): "m/s^2",
    ("km", "h"): "km/h",
    **{(unit, "s"): f"{unit}/s" for unit in ("rad", "mrad", "deg", "m", "mm", "cm")},
}
# Letters that are units behind these words alone: an n behind others points north.
LETTERS = (
    (("m", "n"), "mN", WORDS["thrust"] | WORDS["force"]),
    (("n",), "N", WORDS["thrust"] | WORDS["force"]),
    (("g",), "gf", WORDS["thrust"] | WORDS["force"]),
    (("mnm",), "mN m", WORDS["torque"]),
    (("nm",), "N m", WORDS["torque"]),
    (("m", "v"), "mV", WORDS["battery"]),
    (("v",), "V", WORDS["battery"]),
)

_COMPOUND = re.compile(r"(pos|p|t|vel|v|omega|gyro|gyr|g|w|accel|acc|a|quat|q|force|f|torque|tau|tor|d)_?([wxyz])")
_REVERSED = re.compile(r"([xyz])_?(pos|vel|dot|acc|gyro|rate)")
_ANGLE_RATE = re.compile(r"(roll|pitch|yaw|phi|theta|psi|heading)(rate|speed|dot|vel)")
_NUMBERED = re.compile(r"([a-z]+)(\d)")


def words_and_unit(name: str) -> tuple[list[str], str]:
    """A name's words in lower case without its unit, and the unit that it states, or ""."""
    text = re.sub(r"\[(\d+)\]", r".\1", name)
    unit = ""
    if bracket := re.search(r"[\[(]([^\])]+)[\])]", text):
        written = bracket.group(1).strip()
        unit = WRITTEN_UNITS.get(written, written if written in UNITS else UNIT_WORDS.get(written.lower(), ""))
        text = text.replace(bracket.group(0), "")
    # cflib's compressed estimate carries a Z that is no axis.
    text = re.sub(r"(?i)state_?estimatez?\b", "", text)
    text = re.sub(r"([a-z0-9])([A-Z])", r"\1_\2", text)
    words: list[str] = []
    for word in (part for part in re.split(r"[^a-z0-9]+", text.lower()) if part):
        words += _split(word)
    if words in OF_TIME_ALONE:  # Arduino's millis(), a column `ms`
        return ["time"], UNIT_WORDS[words[0]]
    if not unit:
        words, unit = _unit_behind([word for word in words if word != "per"])
    if "rpm" in words:
        unit = unit or "rpm"
    return words, unit


def _unit_behind(words: list[str]) -> tuple[list[str], str]:
    for tail, unit in TAILS.items():
        if len(words) > len(tail) and tuple(words[-len(tail) :]) == tail:
            return words[: -len(tail)], unit
    for letters, unit, of in LETTERS:
        if tuple(words[-len(letters) :]) == letters and of.intersection(words[: -len(letters)]):
            return words[: -len(letters)], unit
    if len(words) > 1 and words[-1] in UNIT_WORDS:
        return words[:-1], UNIT_WORDS[words[-1]]
    # Behind an axis a w is the world.
    if len(words) > 1 and words[-1] == "w" and words[-2] in {"x", "y", "z"}:
        return words[:-1], ""
    return words, ""


def _split(word: str) -> list[str]:
    if match := _COMPOUND.fullmatch(word):
        stem, axis = match.groups()
        return ["dot" if stem == "d" else stem, axis]
    if match := _REVERSED.fullmatch(word):
        return [match.group(2), match.group(1)]
    if match := _ANGLE_RATE.fullmatch(word):
        return [match.group(1), "rate"]
    if match := _NUMBERED.fullmatch(word):
        return [match.group(1), match.group(2)]
    return [word]
