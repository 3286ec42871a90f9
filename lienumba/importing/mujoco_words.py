"""What MuJoCo says of a file, in one sentence: where, what, and what to do."""

import re
from dataclasses import dataclass


@dataclass(frozen=True)
class Said:
    """where: line and element, "" if it does not say; what: the rule; remedy."""

    where: str
    what: str
    remedy: str


FREE_BASE = "only a body that stands on the ground itself can have a free joint"
RULES = [  # of MuJoCo's words, what they mean and what to do; what it says is quoted in the groups
    (
        "mass and inertia of moving bodies must be larger than mjMINVAL",
        "moves, and has no mass, no inertia, or a negative one",
        "give it an <inertial> or geoms with mass, or take away its joint",
    ),
    (
        "inertia must satisfy A [+] B >= C",
        "one of its moments of inertia exceeds the sum of the others, as in no rigid body",
        "check that they are about the mass centre",
    ),
    (
        "inertia must have positive eigenvalues",
        "its moments of inertia are not all above 0",
        "check the signs and the order xx yy zz xy xz yz",
    ),
    (r"opening file '([^'\n]*)'", r'the file "\1" is not there', "check the path"),
    (r"File '([^'\n]*)' already included", r'the file "\1" is included twice, or includes itself', "include it once"),
    ("Schema violation: unrecognized element", "no such element is known there", "check its name"),
    ("Schema violation: unrecognized attribute: '([^']*)'", r'the attribute "\1" is not known there', "check its name"),
    ("bad format in attribute '([^']*)'", r'the attribute "\1" holds no numbers', "give numbers"),
    ("attribute '([^']*)' does not have enough data", r'the attribute "\1" has too few numbers', "give all of them"),
    ("attribute '([^']*)' has too much data", r'the attribute "\1" has too many numbers', "leave out the others"),
    ("invalid keyword: '([^']*)'", r'"\1" is not one of the words that may stand there', "check its spelling"),
    ("axis too small", "its axis has no direction", "give 3 numbers that are not all 0"),
    ("repeated name '([^']*)' in (.*)", r'two elements of the kind <\2> are called "\1"', "rename one of them"),
    ("unknown default class name '([^']*)'", r'no <default> has the class "\1"', "check its name"),
    (
        "(?:unknown transmission target|unknown element|unrecognized name of (?:joint|body)) '([^']*)'",
        r'nothing there is called "\1"',
        "check the name",
    ),
    ("mesh '([^']*)' not found", r'there is no mesh "\1"', "check the name"),
    (
        r"keyframe '?([^':]*)'?: invalid (\w+) size, expected (?:length )?(\d+)(?:, got (\d+))?",
        r'the \2 of keyframe "\1" must be \3 numbers',
        "give one for each coordinate",
    ),
    ("free joint can only be used on top level", "its free joint is on a body that another carries", FREE_BASE),
]


def said(text: str) -> Said:
    """The sentence for an error of MuJoCo."""
    text = re.sub(r"^(?:XML |URDF )?(?:Error:?\s*|parse error:?\s*)+", "", text.strip(), flags=re.IGNORECASE)
    element = re.search(r"Element (?:name )?'([^']*)'(?:, id (\d+))?(?:, line (\d+))?", text)
    where = ""
    if element is not None:
        line = f"line {element[3]}, " if element[3] and element[3] != "0" else ""
        where = line + (f'element "{element[1]}"' if element[1] else "an element without a name")
        text = text.replace(element[0], "")
    for pattern, what, remedy in RULES:
        found = re.search(pattern, text)
        if found is not None:
            return Said(where, found.expand(what), remedy)
    what = " ".join(text.split()).strip(" .;:,")
    return Said(where, f"MuJoCo: {what}" if what else "MuJoCo cannot read it", "")
