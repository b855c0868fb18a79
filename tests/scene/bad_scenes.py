"""Scenes that must be refused: TOML text, and words that the one message must contain."""

REDUCED = """
[system]
name = "chaplygin-sphere-reduced"
a = [0.8, 1.1, 1.5]
D = 4.0
[initial]
gamma = [0.6, 0.0, 0.8]
p = [0.8, 1.0, -0.6]
[time]
t_end = 1.0
[integrate]
method = "gauss-8"
step = 0.1
[observe]
quantities = ["energy"]
"""

BALL = """
[system]
name = "chaplygin-ball"
moments = [1.0, 2.0, 3.0]
D = 1.0
[initial]
gamma = [0.6, 0.0, 0.8]
k = [1.0, 0.7, -0.4]
[time]
t_end = 1.0
[integrate]
method = "cf-4"
"""


def changed(old: str, new: str, text: str = REDUCED) -> str:
    assert text.count(old) == 1, old
    return text.replace(old, new)


# A name, what is changed in one of the scenes, and words of the message.
TABLE = r"""
a_i a_j >= D: 1.1, 1.5 → 2.9, 1.5 | [system] a | 2.9 | 4.3 | D = 4.0
gamma is zero: [0.6, 0.0, 0.8] → [0.0, 0.0, 0.0] | [initial] gamma | [0.0, 0.0, 0.0] | not zero
gamma is empty: [0.6, 0.0, 0.8] → [] | [initial] gamma | 3 numbers
NaN in gamma: [0.6, 0.0 → [nan, 0.0 | gamma[0] = nan | finite
infinite D: D = 4.0 → D = inf | [system] D = inf | finite
NaN step: step = 0.1 → step = nan | [integrate] step = nan | a finite number
infinite end: t_end = 1.0 → t_end = inf | [time] t_end = inf | finite
p too short: [0.8, 1.0, -0.6] → [0.8, 1.0] | [initial] p | [0.8, 1.0] | 3 numbers, got 2
two momenta: p = [0.8 → k = [1.0]\np = [0.8 | [initial] | exactly one of
n = 1: a = [0.8, 1.1, 1.5] → a = [0.8] | [system] a | [0.8]
negative step: step = 0.1 → step = -0.1 | [integrate] step = -0.1 | > 0
unknown method: "gauss-8" → "gaus-8" | [integrate] method = 'gaus-8' | Did you mean 'gauss-8'?
stages out of range: "gauss-8" → "gauss-99" | method = 'gauss-99'
unknown option: step = 0.1 → tolerence = 0.1 | [integrate] tolerence = 0.1 | Did you mean 'tolerance'?
option of another kind: step = 0.1 → max_iterations = 2.5 | [integrate] max_iterations = 2.5 | a whole number
option that the method lacks: method = "cf-4" → method = "cf-4"\niteration_tolerance = 0.1 | [integrate] iteration_tolerance = 0.1 | 'cf-4'
inertia operator not positive definite: moments = [1.0, 2.0, 3.0] → inertia = [1.0, -2.0, 3.0] | inertia | -2.0 | positive
inertia operator not symmetric: moments = [1.0, 2.0, 3.0] → inertia = [[2.0, 0.5, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]] | inertia | symmetric
both ends: t_end = 1.0 → t_end = 1.0\ntau_end = 2.0 | [time] | exactly one of t_end and tau_end | both
no end: t_end = 1.0 →  | [time] | exactly one of t_end and tau_end
end at 0: t_end = 1.0 → t_end = 0.0 | [time] | must not be 0
tau_end in physical time: t_end = 1.0 → tau_end = 1.0 | [time] tau_end = 1.0 | t_end
unknown key: t_end = 1.0 → t_end = 1.0\nstpe = 1 | [time] stpe = 1 | no such key
unknown key with suggestion: t_end = 1.0 → tend = 1.0 | [time] tend = 1.0 | Did you mean 't_end'?
unknown parameter: D = 4.0 → d = 4.0 | [system] d | Did you mean 'D'?
unknown initial key: gamma = → gama = | [initial] gama | 'gamma'
unknown section: [observe] → [sav]\nevery = 1\n[observe] | sav | Did you mean 'save'?
unknown system: chaplygin-sphere-reduced → chaplygin-spere-reduced | [system] name | Did you mean 'chaplygin-sphere-reduced'?
unknown quantity: ["energy"] → ["enery"] | [observe] quantities[0] = 'enery' | Did you mean 'energy'?
step is a string: step = 0.1 → step = "0.1" | [integrate] step = '0.1' | a number
parameter is a string: D = 4.0 → D = "4" | [system] D = '4' | a number
a is no list: a = [0.8, 1.1, 1.5] → a = 1.0 | [system] a = 1.0 | a list
unknown key of [observe]: ["energy"] → ["energy"]\neverry = 2 | [observe] everry = 2 | Did you mean 'every'?
every is 0: ["energy"] → ["energy"]\nevery = 0 | [observe] every = 0 | ≥ 1
every is a fraction: ["energy"] → ["energy"]\nevery = 1.5 | [observe] every = 1.5 | whole number
two ways to save: [observe] → [save]\nevery = 1\nt_eval = [0.5]\n[observe] | [save] | every or t_eval
moments that make products round to D: [1.0, 2.0, 3.0] → [1e308, 1e308, 1.0] | [system] moments | 1e+308 | 10¹⁵ D
a switch that is a word: D = 1.0 → D = 1.0\nattitude = "no" | [system] attitude = 'no' | true or false
the same method twice: [observe] → [drift]\nmethods = ["gauss-4", "rk-4:0.1", "gauss-4"]\n[observe] | [drift] methods | once
TOML syntax: D = 4.0 → D =  | not valid TOML | line 5
key twice: D = 4.0 → D = 4.0\nD = 5.0 | not valid TOML | line 6
method of [drift]: [observe] → [drift]\nmethod = "rk4"\n[observe] | [drift] method = 'rk4' | 'rk-4'
methods of [compare]: [observe] → [compare]\nmethods = ["cf-4", "cf4"]\n[observe] | [compare] | 'cf4' | 'cf-4'
"""  # noqa: E501


def read(line: str) -> tuple[str, tuple[str, list[str]]]:
    name, _, case = line.partition(": ")
    change, *words = case.split(" | ")
    old, _, new = change.replace(r"\n", "\n").partition(" → ")
    text = REDUCED if REDUCED.count(old) == 1 else BALL
    return name, (changed(old, new, text), words)


OF = '[system]\nname = "{}"\n{}\n[initial]\n{}\n[time]\nt_end = 1.0\n'
HEAVY = "m = {}\nrho = {}\nmoments = {}"
SINGULAR = ["[system] or [initial]", "moments and D", "singular"]
ROUND = "n = {}\ns = 1.0\nD = 1.0", "gamma = [1.0]\nk = []"


BAD: dict[str, tuple[str, list[str]]] = {
    **dict(map(read, TABLE.strip().splitlines())),
    "homogeneous n = 1": (
        OF.format("homogeneous-ball", *ROUND).format(1), ["[system] n = 1", "≥ 2"],
    ),
    "a dimension for which there is no memory": (
        OF.format("homogeneous-ball", *ROUND).format(2**53),
        ["[system] n = 9007199254740992", "from 2 to 1000"],
    ),
    "a ball beyond the digits of its moments": (
        OF.format(
            "rolling-ball", HEAVY.format(2.0, 5e11, [0.4, 0.5, 0.7]),
            "gamma = [0.48, 0.6, 0.64]\nomega = [1.0, -2.0, 1.5]",
        ),
        SINGULAR,
    ),
    "a body beyond the digits of its moments": (
        OF.format(
            "rubber-ball", HEAVY.format(1.2, 1.0, [1.0, 1.5e164, 2.0]),
            "gamma = [0.48, 0.6, 0.64]\np = [0.8, 0.0, -0.6]",
        ),
        SINGULAR,
    ),
    "section is a number": ("system = 3\n[time]\nt_end = 1.0\n", ["[system] = 3", "section"]),
    "no system": ("[time]\nt_end = 1.0\n", ["[system] is missing"]),
    "every beyond what counts": (
        changed('["energy"]', f'["energy"]\nevery = {2**63}'),
        ["[observe] every", "a number ≤ 9.0072e+15"],
    ),
    "an integer of 5000 digits": (
        changed("4.0", "9" * 5000), ["too long an integer", "thousands of digits"],
    ),
    "an integer of 6000 digits in hexadecimal": (
        changed("4.0", "0x" + "f" * 5000),
        ["[system] D = <an integer of about 6021 digits>", "a number below 10³⁰⁰"],
    ),
    "an integer beyond floats": (
        changed("4.0", "1" + "0" * 400), ["[system] D = 1000", "a number below 10³⁰⁰"],
    ),
    "lists in lists": (
        changed("4.0", "[" * 100 + "]" * 100), ["[system] D", "nested at most 20 deep"],
    ),
    "lists in thousands of lists": (
        changed("4.0", "[" * 5000 + "]" * 5000), ["is too deep", "not nested in hundreds"],
    ),
    "tables in thousands of tables": (
        REDUCED + "a" + ".a" * 2000 + " = 1\n", ["[observe] a", "nested at most 20 deep"],
    ),
    "two thousand compositions": (
        changed('"gauss-8"', '"gauss-1' + "-suzuki-4" * 2000 + '"'),
        ["[integrate] method = 'gauss-1-suzuki-4", "no such method"],
    ),
    "control characters in a key": (
        changed("D = 4.0", 'D = 4.0\n"a\\u001b[31m" = 1'),
        ["[system] 'a\\x1b[31m' = 1", "no such key"],
    ),
}  # fmt: skip
