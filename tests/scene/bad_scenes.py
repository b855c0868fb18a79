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


BAD = {
    "a_i a_j >= D": (changed("1.1, 1.5", "2.9, 1.5"), ["[system] a", "2.9", "4.3", "D = 4.0"]),
    "gamma is zero": (
        changed("[0.6, 0.0, 0.8]", "[0.0, 0.0, 0.0]"),
        ["[initial] gamma", "[0.0, 0.0, 0.0]", "not zero"],
    ),
    "gamma is empty": (changed("[0.6, 0.0, 0.8]", "[]"), ["[initial] gamma", "3 numbers"]),
    "NaN in gamma": (changed("[0.6, 0.0", "[nan, 0.0"), ["gamma[0] = nan", "finite"]),
    "infinite D": (changed("D = 4.0", "D = inf"), ["[system] D = inf", "finite"]),
    "NaN step": (
        changed("step = 0.1", "step = nan"),
        ["[integrate] step = nan", "a finite number"],
    ),
    "infinite end": (changed("t_end = 1.0", "t_end = inf"), ["[time] t_end = inf", "finite"]),
    "p too short": (
        changed("[0.8, 1.0, -0.6]", "[0.8, 1.0]"),
        ["[initial] p", "[0.8, 1.0]", "3 numbers, got 2"],
    ),
    "two momenta": (changed("p = [0.8", "k = [1.0]\np = [0.8"), ["[initial]", "exactly one of"]),
    "n = 1": (
        changed("a = [0.8, 1.1, 1.5]", "a = [0.8]"),
        ["[system] a", "[0.8]"],
    ),
    "homogeneous n = 1": (
        """
        [system]
        name = "homogeneous-ball"
        n = 1
        s = 1.0
        D = 1.0
        [initial]
        gamma = [1.0]
        k = []
        [time]
        t_end = 1.0
        """,
        ["[system] n = 1", "≥ 2"],
    ),
    "negative step": (changed("step = 0.1", "step = -0.1"), ["[integrate] step = -0.1", "> 0"]),
    "unknown method": (
        changed('"gauss-8"', '"gaus-8"'),
        ["[integrate] method = 'gaus-8'", "Did you mean 'gauss-8'?"],
    ),
    "stages out of range": (changed('"gauss-8"', '"gauss-99"'), ["method = 'gauss-99'"]),
    "unknown option": (
        changed("step = 0.1", "tolerence = 0.1"),
        ["[integrate] tolerence = 0.1", "Did you mean 'tolerance'?"],
    ),
    "option of another kind": (
        changed("step = 0.1", "max_iterations = 2.5"),
        ["[integrate] max_iterations = 2.5", "a whole number"],
    ),
    "option that the method lacks": (
        changed('method = "cf-4"', 'method = "cf-4"\niteration_tolerance = 0.1', BALL),
        ["[integrate] iteration_tolerance = 0.1", "'cf-4'"],
    ),
    "inertia operator not positive definite": (
        changed("moments = [1.0, 2.0, 3.0]", "inertia = [1.0, -2.0, 3.0]", BALL),
        ["inertia", "-2.0", "positive"],
    ),
    "inertia operator not symmetric": (
        changed(
            "moments = [1.0, 2.0, 3.0]",
            "inertia = [[2.0, 0.5, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]]",
            BALL,
        ),
        ["inertia", "symmetric"],
    ),
    "both ends": (
        changed("t_end = 1.0", "t_end = 1.0\ntau_end = 2.0"),
        ["[time]", "exactly one of t_end and tau_end", "both"],
    ),
    "no end": (changed("t_end = 1.0", ""), ["[time]", "exactly one of t_end and tau_end"]),
    "end at 0": (changed("t_end = 1.0", "t_end = 0.0"), ["[time]", "must not be 0"]),
    "tau_end in physical time": (
        changed("t_end = 1.0", "tau_end = 1.0"),
        ["[time] tau_end = 1.0", "t_end"],
    ),
    "unknown key": (
        changed("t_end = 1.0", "t_end = 1.0\nstpe = 1"),
        ["[time] stpe = 1", "no such key"],
    ),
    "unknown key with suggestion": (
        changed("t_end = 1.0", "tend = 1.0"),
        ["[time] tend = 1.0", "Did you mean 't_end'?"],
    ),
    "unknown parameter": (changed("D = 4.0", "d = 4.0"), ["[system] d", "Did you mean 'D'?"]),
    "unknown initial key": (changed("gamma =", "gama ="), ["[initial] gama", "'gamma'"]),
    "unknown section": (REDUCED + "[sav]\nevery = 1\n", ["sav", "Did you mean 'save'?"]),
    "unknown system": (
        changed("chaplygin-sphere-reduced", "chaplygin-spere-reduced"),
        ["[system] name", "Did you mean 'chaplygin-sphere-reduced'?"],
    ),
    "unknown quantity": (
        changed('["energy"]', '["enery"]'),
        ["[observe] quantities[0] = 'enery'", "Did you mean 'energy'?"],
    ),
    "step is a string": (
        changed("step = 0.1", 'step = "0.1"'),
        ["[integrate] step = '0.1'", "a number"],
    ),
    "parameter is a string": (changed("D = 4.0", 'D = "4"'), ["[system] D = '4'", "a number"]),
    "a is no list": (changed("a = [0.8, 1.1, 1.5]", "a = 1.0"), ["[system] a = 1.0", "a list"]),
    "every is 0": (
        changed('["energy"]', '["energy"]\nevery = 0'),
        ["[observe] every = 0", "≥ 1"],
    ),
    "every is a fraction": (
        changed('["energy"]', '["energy"]\nevery = 1.5'),
        ["[observe] every = 1.5", "whole number"],
    ),
    "two ways to save": (
        REDUCED + "[save]\nevery = 1\nt_eval = [0.5]\n",
        ["[save]", "every or t_eval"],
    ),
    "section is a number": ("system = 3\n[time]\nt_end = 1.0\n", ["[system] = 3", "section"]),
    "no system": ("[time]\nt_end = 1.0\n", ["[system] is missing"]),
    "every beyond what counts": (
        changed('["energy"]', f'["energy"]\nevery = {2**63}'),
        ["[observe] every", "a number ≤ 9.0072e+15"],
    ),
    "an integer of 5000 digits": (
        changed("D = 4.0", f"D = {'9' * 5000}"),
        ["too long an integer", "thousands of digits"],
    ),
    "an integer of 6000 digits in hexadecimal": (
        changed("D = 4.0", f"D = 0x{'f' * 5000}"),
        ["[system] D = <an integer of about 6021 digits>", "a number below 10³⁰⁰"],
    ),
    "an integer beyond floats": (
        changed("D = 4.0", f"D = 1{'0' * 400}"),
        ["[system] D = 1000", "a number below 10³⁰⁰"],
    ),
    "lists in lists": (
        changed("D = 4.0", f"D = {'[' * 100}{']' * 100}"),
        ["[system] D", "nested at most 20 deep"],
    ),
    "lists in thousands of lists": (
        changed("D = 4.0", f"D = {'[' * 5000}{']' * 5000}"),
        ["is too deep", "not nested in hundreds"],
    ),
    "tables in thousands of tables": (
        REDUCED + "a" + ".a" * 2000 + " = 1\n",
        ["[observe] a", "nested at most 20 deep"],
    ),
    "two thousand compositions": (
        changed('"gauss-8"', '"gauss-1' + "-suzuki-4" * 2000 + '"'),
        ["[integrate] method = 'gauss-1-suzuki-4", "no such method"],
    ),
    "control characters in a key": (
        changed("D = 4.0", 'D = 4.0\n"a\\u001b[31m" = 1'),
        ["[system] 'a\\x1b[31m' = 1", "no such key"],
    ),
    "moments that make products round to D": (
        changed("[1.0, 2.0, 3.0]", "[1e308, 1e308, 1.0]", BALL),
        ["[system] moments", "1e+308", "10¹⁵ D"],
    ),
    "a ball beyond the digits of its moments": (
        """
        [system]
        name = "rolling-ball"
        moments = [0.4, 0.5, 0.7]
        m = 2.0
        rho = 5e11
        [initial]
        gamma = [0.48, 0.6, 0.64]
        omega = [1.0, -2.0, 1.5]
        [time]
        t_end = 1.0
        """,
        ["[system] or [initial]", "moments and D", "singular"],
    ),
    "a body beyond the digits of its moments": (
        """
        [system]
        name = "rubber-ball"
        moments = [1.0, 1.5e164, 2.0]
        m = 1.2
        rho = 1.0
        [initial]
        gamma = [0.48, 0.6, 0.64]
        p = [0.8, 0.0, -0.6]
        [time]
        t_end = 1.0
        """,
        ["[system] or [initial]", "moments and D", "singular"],
    ),
    "a dimension for which there is no memory": (
        """
        [system]
        name = "homogeneous-ball"
        n = 9007199254740992
        s = 1.0
        D = 1.0
        [initial]
        gamma = [1.0]
        k = []
        [time]
        t_end = 1.0
        """,
        ["[system] n = 9007199254740992", "from 2 to 1000"],
    ),
    "a switch that is a word": (
        changed("D = 1.0", 'D = 1.0\nattitude = "no"', BALL),
        ["[system] attitude = 'no'", "true or false"],
    ),
    "the same method twice": (
        REDUCED + '[drift]\nmethods = ["gauss-4", "rk-4:0.1", "gauss-4"]\n',
        ["[drift] methods", "once"],
    ),
    "TOML syntax": (changed("D = 4.0", "D = "), ["not valid TOML", "line 5"]),
    "key twice": (changed("D = 4.0", "D = 4.0\nD = 5.0"), ["not valid TOML", "line 6"]),
    "method of [drift]": (
        REDUCED + '[drift]\nmethod = "rk4"\n',
        ["[drift] method = 'rk4'", "'rk-4'"],
    ),
    "methods of [compare]": (
        REDUCED + '[compare]\nmethods = ["cf-4", "cf4"]\n',
        ["[compare]", "'cf4'", "'cf-4'"],
    ),
}
