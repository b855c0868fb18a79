"""The tables of pages that are made of results and registries: a page cannot differ from them."""

from __future__ import annotations

import importlib
import json
import math
import pkgutil
import re
import types
import typing
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from geomint.problems.systems import find_system, system_names
from geomint.scene.load import builtin_scenes, load_scene

RESULTS = Path(__file__).parents[1] / "benchmarks" / "results"


def result(name: str) -> dict[str, Any]:
    """Return a benchmark's own record."""
    found: dict[str, Any] = json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))
    return found


def _table(heads: list[str], rows: list[list[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def measured_on(record: dict[str, Any]) -> str:
    """Return the machine and the versions of a result."""
    machine = record["machine"]
    cpu = machine["cpu"].replace("(R)", "")
    versions = ", ".join(f"{name} {version}" for name, version in machine["versions"].items())
    return f"{cpu}, Python {machine['python']}, {versions}"


def benchmark() -> str:
    """Return times at two errors against heyoka."""
    record = result("hamiltonized_n3")
    versions = record["machine"]["versions"]
    heads = ["error", f"geomint {versions['geomint']} (ms)", f"heyoka {versions['heyoka']} (ms)"]
    rows = [
        [
            f"{float(error):g}",
            f"{row['geomint_ms']:.1f}",
            f"{row['heyoka_ms']:.1f}",
            f"{row['heyoka_over_geomint']:.1f}",
        ]
        for error, row in record["at_error"].items()
    ]
    return _table([*heads, "ratio"], rows)


def against_peers(mean: str, least: bool) -> str:
    """Return the ratios against heyoka, from random states: of whole calls, or of steps alone."""
    rows, goals = result("against_peers")["rows"], ("1e-06", "1e-09", "1e-10")
    heads = ["problem", "end", *(f"error {float(goal):g}" for goal in goals)]
    found: dict[tuple[str, float], dict[str, str]] = {}
    for row in rows:
        cells = found.setdefault((row["problem"], row["end"]), {})
        worst = f" ({row['least']:.2g})" if least else ""
        cells[f"{row['goal']:g}"] = f"{row[mean]:.2g}{worst}"
    return _table(
        heads,
        [
            [name, f"{end:g}", *(cells[goal] for goal in goals)]
            for (name, end), cells in found.items()
        ],
    )


def peers() -> str:
    """Return what a step costs in lielab and Mici."""
    record = result("peers_per_step")
    seconds, versions = record["seconds_per_step"], record["machine"]["versions"]
    lielab = min(seconds["lielab with_arrays"], seconds["lielab with_numbers"])
    found = [
        (f"lielab {versions['lielab']}, RKMK", lielab, seconds["geomint rkmk-4"]),
        (
            f"Mici {versions['mici']}, constrained leapfrog",
            seconds["mici"],
            seconds["geomint rattle-2"],
        ),
    ]
    rows = [
        [code, f"{1e6 * theirs:.0f}", f"{1e6 * ours:.2f}", f"{theirs / ours:.0f}"]
        for code, theirs, ours in found
    ]
    return _table(["code", "µs a step", "geomint", "ratio"], rows)


def kernel_limits() -> str:
    """Return what a step has to do, and how near to the limit it is."""
    heads = [
        "system", "method", "operations", "divisions, roots", "kB", "limit (ns)", "step (ns)", "ratio",
    ]  # fmt: skip
    rows = [
        [
            row["system"], f"`{row['method']}`{' in lanes' if row['in_lanes'] else ''}",
            f"{row['operations']:.0f}", f"{row['divisions_and_roots']:.0f}",
            f"{row['bytes'] / 1000.0:.0f}", f"{row['limit_ns']:.0f}", f"{row['step_ns']:.0f}",
            f"{row['ratio']:.1f}",
        ]
        for row in result("kernel_limits")["rows"]
    ]  # fmt: skip
    return _table(heads, rows)


def step_cost() -> str:
    """Return what a step of each method costs."""
    heads = ["scene", "numbers in the state", "method", "step", "ns a step", "evaluations a step"]
    rows, before = [], ""
    for row in result("step_cost")["rows"]:
        place = [row["title"], str(row["numbers"])] if row["title"] != before else ["", ""]
        before = row["title"]
        numbers = [f"{row['step']:g}", f"{row['ns']:.0f}", f"{row['evaluations']:.0f}"]
        cost = row["ns"] / row["evaluations"]
        each = f"{cost:.0f}" if cost >= 10.0 else f"{cost:.1f}"
        rows.append([*place, f"`{row['method']}`", *numbers, each])
    return _table([*heads, "ns an evaluation"], rows)


def elementary() -> str:
    """Return errors and costs of elementary functions."""
    heads = ["function", "largest error (ulp)", "one at a time (ns)", "eight at once (ns)"]
    heads += ["C library, one at a time (ns)", "its error (ulp)", "numpy (ns)"]
    rows = [
        [
            f"`gi.{name}`",
            *(f"{row['largest_error']:.2f}", f"{row['one']:.0f}", f"{row['eight']:.1f}"),
            *(f"{row['library']:.0f}", f"{row['library_error']:.2f}", f"{row['numpy']:.1f}"),
        ]
        for name, row in result("elementary")["rows"].items()
    ]
    return _table(heads, rows)


def main_job() -> str:
    """Return what the drift report of the ball costs."""
    record = result("observer_loop")
    seconds = record["seconds"]
    rows = [
        [
            "a million steps of `ball-3d` with `cf-4`, five quantities after every step",
            seconds["loop"],
        ],
        ["`geomint drift ball-3d`, the whole command, code in the cache", seconds["command"]],
        ["the same with an empty cache", record["cold_command_seconds"]],
        ["of which compilation", seconds["cold_compilation"]],
        ["`geomint --help`", seconds["help"]],
        ["an unknown scene name", seconds["typo"]],
    ]
    return _table(["what", "seconds"], [[what, f"{value:.2g}"] for what, value in rows])


def methods(name: str) -> str:
    """Return a table of the page that helps to choose a method."""
    table = result("method_tables")["tables"][name]
    rows = []
    for point in table["shown"]:
        own = "" if point["representation"] != "reduced" else ", reduced, in t"
        cells = [f"`{point['method']}`{own}", f"{point['step']:.2g}"]
        if point["error"] is None:
            rows.append([*cells, point["status"].split(":")[0].split(" (")[0], ""])
            continue
        rows.append([*cells, f"{point['error']:.1e}", f"{point['seconds']:.2g}"])
    return _table(["method", "step", "error", "seconds"], rows)


def splittings() -> str:
    """Return the same with times relative to the first method."""
    shown = result("method_tables")["tables"]["splittings"]["shown"]
    rows = [
        [
            f"`{point['method']}`",
            f"{point['step']:g}",
            f"{point['error']:.1e}",
            f"{point['seconds'] / shown[0]['seconds']:.2g}",
        ]
        for point in shown
    ]
    return _table(["method", "step", "error", "time"], rows)


def elsewhere() -> dict[str, str]:
    """Return the ratios against heyoka on a second machine, in words."""
    record = result("hamiltonized_n3_elsewhere")
    errors = [f"{ratio} at {float(error):.0e}" for error, ratio in record["at_error"].items()]
    return {"elsewhere_errors": " and ".join(errors).replace("e-0", "e-")}


def on_the_manifold() -> str:
    """Return what symplectic maps on the manifold cost against gauss-8: one state, and means."""
    record = result("on_the_manifold")
    readme, means = record["states"]["readme"], record["means"]
    rows = []
    for method, steps in readme["steps"].items():
        ratios = [readme[kind][method] / readme[kind]["gauss-8"] for kind in means]
        ratios += [mean[method] for mean in means.values()]
        times = [f"{x:.1f}" if x < 10 else f"{x:.0f}" for x in ratios]
        rows.append([f"`{method}`", str(steps), *times])
    heads = ["method", "steps", "call", "steps alone", "nine states: call", "steps alone"]
    return _table(heads, rows)


def times_table() -> str:
    """Return how long states at given times take, against heyoka."""
    names = {
        "chaplygin-sphere-reduced": "reduced, in physical time",
        "chaplygin-sphere-hamiltonized": "Hamiltonised, at physical times",
    }
    rows = [
        [names[name], goal, *(f"{row[key]:.2f}" for key in ("geometric_mean", "least", "largest"))]
        for name, goals in result("states_at_times")["problems"].items()
        for goal, row in goals.items()
    ]
    heads = ["problem", "error below", "geomint / heyoka", "least", "largest"]
    return _table(heads, rows)


def times_words() -> dict[str, str]:
    """Return the same beside the table."""
    found = result("states_at_times")
    return {
        "times": times_table(),
        "million": f"{found['seconds_for_a_million']:.1f}",
        "times_machine": measured_on(found),
    }


def sections_table() -> str:
    """Return points of sections a second, against heyoka."""
    heads = ["state", "step", "geomint, points a second", "heyoka", "ratio", "error of geomint"]
    rows = []
    for i, row in enumerate(result("section_points")["states"]):
        name = f"random {i}" if i else "`ball-3d`"
        speeds = [f"{round(row[f'{code}_per_second'], -3):.0f}" for code in ("geomint", "heyoka")]
        errors = [f"{row[f'{code}_error']:.1e}" for code in ("geomint", "heyoka")]
        rows.append([name, str(row["geomint_step"]), *speeds, f"{row['ratio']:.2f}", *errors])
    return _table([*heads, "of heyoka"], rows)


def sections_words() -> dict[str, str]:
    """Return the same beside the table."""
    found = result("section_points")
    return {
        "sections": sections_table(),
        "sections_mean": f"{found['geometric_mean']:.2f}",
        "sections_least": f"{found['least']:.2f}",
        "sections_machine": measured_on(found),
    }


def plan_scenes() -> str:
    """Return what plans of the built-in scenes leave out."""
    ways = ("plain", "run", "drift")
    heads = ["scene", *(f"{what}, {way}" for what in ("ms", "MB") for way in ways), "evaluations"]
    rows = []
    for row in result("plan_table")["scenes"]:
        found = [row["ways"][way] for way in ways]
        times, sizes = ([way[key] for way in found] for key in ("seconds", "bytes"))
        cells = [f"{1e3 * x:.0f}" for x in times] + [f"{1e-6 * x:.2g}" for x in sizes]
        rows.append([f"`{row['name']}`", *cells, f"{found[0]['evaluations']:,}".replace(",", " ")])
    return _table(heads, rows)


def plan_rules() -> str:
    """Return what further rules of the planner gain."""
    heads = [
        "what is asked for",
        "taken",
        "s, plain",
        "s",
        "ratio",
        "evaluations, plain",
        "evaluations",
    ]
    rows = []
    for row in result("plan_table")["rules"]:
        plain, run = row["ways"]["plain"], row["ways"]["run"]
        ratio = f"{plain['seconds'] / run['seconds']:.2g}"
        seconds = [f"{way['seconds']:.2g}" for way in (plain, run)]
        counts = [f"{way['evaluations']:.3g}" for way in (plain, run)]
        rows.append([row["label"], row["taken"], *seconds, ratio, *counts])
    return _table(heads, rows)


KINDS = {
    "energy": "energy",
    "integrals": "other integrals",
    "constraints": "constraints",
    "measure": "measure",
}


def drift_tables() -> dict[str, str]:
    """Return a table for each scene of the benchmark of drifts: largest deviation, worst class."""
    scenes = result("drift_by_method")["scenes"]
    return {f"drift_{name.replace('-', '_')}": _drift_table(s) for name, s in scenes.items()}


def _drift_table(scene: dict[str, Any]) -> str:
    rows = []
    for label, method in scene["methods"].items():
        run = method["run"]
        if run is None:
            rows.append([f"`{label}`", f"{method['status']}: {method['message']}", *[""] * 6])
            continue
        time = {"t": "t", "tau": "τ"}[run["time"]]
        each = 1e6 * run["run_seconds"] / max(run["steps"], 1)
        cells = [f"`{label}`", method["representation"], f"{run['step']:.3g} in {time}"]
        rows.append([*cells, f"{each:.2g}", *(_drift_cell(scene, method, kind) for kind in KINDS)])
    return _table(["method", "representation", "step", "µs a step", *KINDS.values()], rows)


def _drift_cell(scene: dict[str, Any], method: dict[str, Any], kind: str) -> str:
    """Return the largest deviation / scale (of the measure: the deviation) and its class."""
    found = [q for name, q in method["quantities"].items() if scene["kinds"][name] == kind]
    sizes = [(q["max_abs_error"] / (q["scale"] if kind != "measure" else 1.0), q) for q in found]
    if not sizes:
        return "–"
    size, worst = max(sizes, key=lambda pair: pair[0])
    return f"{size:.1e} `{worst['class']}`"


def scene_keys() -> str:
    """Return every key of ``[system]`` and ``[initial]`` of every registered system."""
    rows = []
    for name in system_names():
        system = find_system(name)
        summary = system.summary.replace("|", "\\|").replace("*", "\\*")
        rows.append([f"`{name}`: {summary}", _keys(system.parameters), _keys(system.initial)])
    return _table(["system", "`[system]`", "`[initial]`"], rows)


def _keys(model: type[BaseModel]) -> str:
    return "; ".join(
        f"`{key}` {_kind(field)}" + (f": {field.description}" if field.description else "")
        for key, field in model.model_fields.items()
    )


def scenes() -> str:
    """Return every built-in scene with its problem: state, time, forms, and what may be watched."""
    rows = []
    for name in builtin_scenes():
        scene = load_scene(name)
        problem = scene.problem
        state = ", ".join(f"`{piece}` ({size})" for piece, size in problem.pieces)
        words = [f"`{name}`: {scene.content.title}", f"`{scene.content.system.name}`", state]
        rows.append([*words, {"t": "t", "tau": "τ"}[problem.time], ", ".join(problem.forms)])
    return _table(["scene", "system", "state", "time", "forms"], rows)


def with_modules(text: str) -> str:
    """Return an API page with the modules of a package for ``.. modules:: PACKAGE``."""
    return re.sub(r"^\.\. modules:: (\S+)\n", _modules, text, flags=re.MULTILINE)


def _modules(found: re.Match[str]) -> str:
    path = importlib.import_module(found[1]).__path__
    names = [found[1], *(f"{found[1]}.{module.name}" for module in pkgutil.iter_modules(path))]
    return "\n".join(f".. automodule:: {name}\n" for name in names)


def error_words() -> dict[str, str]:
    """Return how good estimates of errors are."""
    record = result("error_estimate")
    ends = [key for key in record if key != "machine"]
    found = [record[end]["summary"] for end in ends]
    ratios = [row["estimate"] / row["error"] for end in ends for row in record[end]["rows"]]
    off = [
        row["error"]
        for end in ends
        for row in record[end]["rows"]
        if not 0.1 <= row["estimate"] / row["error"] <= 10.0
    ]
    mean = [one["geometric mean"] for one in found]
    return {
        "error_runs": str(sum(one["runs"] for one in found)),
        "error_states": f"to times {' and '.join(ends)}",
        "error_mean": f"{min(mean):.2f}",
        "error_least": f"{min(ratios):.2f}",
        "error_largest": f"{max(ratios):.1f}",
        "error_beyond": str(len(off)),
        "error_below": f"{10.0 ** math.ceil(math.log10(max(off))):.0e}",
    }


def tolerance_words() -> dict[str, str]:
    """Return how well tolerances are met, and what choosing costs."""
    record = result("tolerance")
    rows = []
    names = {f"auto, {key}": one for key, one in record["auto"].items() if key != "all"}
    for name, one in {**names, "auto, own systems": record["own"], **record["methods"]}.items():
        times = [
            f"{one[key]:.2f}" if key in one else "" for key in ("run_over_best", "call_over_best")
        ]
        cells = [one["within 0.01 … 10"], one["within 0.03 … 3"]]
        share = [f"{100.0 * x:.0f} %" for x in cells]
        ends = [f"{one[key]:.2g}" for key in ("median", "least", "largest")]
        rows.append([name, str(one["runs"]), *share, *ends, *times])
    heads = ["method, tolerance", "runs", "within 0.01 … 10", "within 0.03 … 3", "median", "least"]
    every = [*record["rows"], *record["rows of methods"], *record["rows of own systems"]]
    beyond = [row for row in every if not 0.01 <= row["error_over_tolerance"] <= 10.0]
    return {
        "tolerance_runs": str(len(every)),
        "tolerance_beyond": str(len(beyond)),
        "tolerance_end": f"{record['end']:g}",
        "tolerance_table": _table([*heads, "largest", "run", "call"], rows),
        "tolerance_free": str(sum(row.get("free", False) for row in beyond)),
        "tolerance_machine": measured_on(record),
    }


def traps_words() -> dict[str, str]:
    """Return how often a run is wrong and gives no warning."""
    record = result("traps")
    rows = []
    for seed, one in {**record["seeds"], "all": record["all"]}.items():
        shares = [f"{100.0 * one['shares'][key]:.2f} %" for key in ("silent", "warned", "refused")]
        counts = [str(one.get(key, 0)) for key in ("motions", "told", "unknown")]
        rows.append([seed, *counts, *shares])
    heads = ["seed", "motions", "wrong, and told", "truth not known", "wrong in silence"]
    return {"traps_table": _table([*heads, "warned though right", "refused"], rows)}


def uneven_words() -> dict[str, str]:
    """Return evaluations and drifts of uneven steps on ellipsoids."""
    record = result("uneven")
    heads = ["semi-axes", "steps", *(f"{bound:g}" for bound in record["bounds"])]
    rows, drifts = [], []
    watched = ("energy", "joachimsthal", "ellipsoid", "tangency", "measure")
    for axes, found in record["ellipsoids"].items():
        even = found["curves"]["fixed step"]["mean"]
        for name, one in found["curves"].items():
            pairs = zip(one["mean"], even, strict=True)
            rows.append([axes, name, *(f"{n:.0f} ({e / n:.1f})" for n, e in pairs)])
        for name, one in found["drift"].items():
            kept = (one["drift"][key] for key in watched)
            drifts.append([axes, name, *(f"{d['largest']:.0e}, {d['class']}" for d in kept)])
    gains = [gain for one in record["sphere"]["gains"] for gain in one]
    return {
        "uneven_table": _table(heads, rows),
        "uneven_drifts": _table(["semi-axes", "steps", *watched], drifts),
        "uneven_states": str(
            len(next(iter(record["ellipsoids"].values()))["curves"]["fixed step"]["errors"])
        ),
        "uneven_gains": f"{min(gains):.1f} to {max(gains):.1f}",
        "uneven_headroom": f"{100.0 * (max(record['sphere']['longer']) - 1.0):.0f} %",
    }


def another_time_words() -> dict[str, str]:
    """Return the largest errors and the times of calls of uneven motions by method "auto"."""
    record, ways = result("another_time"), ("auto", "fixed", "adaptive")
    orbits = [row for row in record["rows"] if row["e"] is not None]
    rows = []
    for tolerance, e in sorted({(row["tolerance"], row["e"]) for row in orbits}, reverse=True):
        some = [row for row in orbits if (row["tolerance"], row["e"]) == (tolerance, e)]
        cells = [f"{tolerance:g}", f"{e:g}", *sorted({row["auto"]["problem"] for row in some})[-1:]]
        for way in ways:
            worst = max(row[way]["error_over_tolerance"] for row in some)
            times = [row[way]["call_milliseconds"] for row in some]
            cells.append(f"{math.prod(times) ** (1.0 / len(times)):.0f} ms, {worst:.2g}")
        rows.append(cells)
    heads = ["tolerance", "eccentricity", "run", '`"auto"`', "Gauss in t", "`dop853-adaptive`"]
    words = {"another_time_table": _table(heads, rows)}
    return {**words, "another_time_machine": measured_on(record)}


def frequency_words() -> dict[str, str]:
    """Return how exact frequencies of runs are, and what their digits tell."""
    record = result("frequencies")
    exact, run = (record["errors"][source] for source in ("exact flow", "gauss-8"))
    samples = "32000"
    motions = [told for one in record["verdicts"].values() for told in one["motions"]]
    pairs = [tuple(told[:2]) for told in motions]
    against = [pair for pair in pairs if set(pair) == {"regular", "chaotic"}]
    found = {
        "frequency_states": str(record["states"]),
        "frequency_periods": f"{int(samples) / 12:.0f}",
        "verdict_motions": str(len(motions)),
        "verdict_against": str(len(against)) if against else "none",
        "verdict_undecided": str(sum("undecided" in pair for pair in pairs)),
    }
    for name, errors in (
        ("frequency", exact[samples]["birkhoff"]),
        ("frequency_laskar", exact[samples]["laskar"]),
        ("frequency_run", run[samples]["birkhoff"]),
    ):
        found |= {f"{name}_{which}": f"{errors[which]:.0e}" for which in ("mean", "worst")}
    return found


def lyapunov_words() -> dict[str, str]:
    """Return Lyapunov exponents beside those of another code, and what they cost."""
    record = result("lyapunov")
    rows = []
    for energy, one in record["chaotic"].items():
        told = one["means"]
        cells = [
            f"{told[code]['mean']:.4f} ± {told[code]['standard error']:.4f}"
            for code in ("rk-4", "gauss-8", "pynamicalsys")
        ]
        ratios = [f"{told[f'time over that of {name}']:.0f}" for name in ("rk-4", "gauss-8")]
        rows.append([f"1/{1 / float(energy):.0f}", *cells, *ratios])
    heads = ["energy", "`rk-4`, step 0.02", "`gauss-8`, step 0.4", "pynamicalsys"]
    ends = [one["along"][-1]["over ln(t/T)/t"] for one in record["integrable"].values()]
    costs = record["million steps"]
    return {
        "lyapunov_table": _table([*heads, "times `rk-4`", "times `gauss-8`"], rows),
        "lyapunov_motions": str(next(iter(record["chaotic"].values()))["means"]["motions"]),
        "lyapunov_regular": ", ".join(f"{x:.2f}" for x in ends),
        "lyapunov_rk": f"{costs['rk-4']:.1f}",
        "lyapunov_gauss": f"{costs['gauss-8']:.1f}",
        "lyapunov_machine": measured_on(record),
    }


def ensemble_words() -> dict[str, str]:
    """Return what ensembles cost, and heyoka's beside them."""
    record, chart = result("ensembles"), result("ensemble_chart")
    heads = ["scene", "method", "single step (ns)", "step in company (ns)", "throughput", "cores"]
    rows = [
        [
            f"`{scene}`",
            f"`{name}`",
            f"{one['single_ns']:.0f}",
            f"{one['member_ns']:.0f}",
            f"{one['throughput']:.1f}",
            f"{one['cores']:.2f}",
        ]
        for scene, own in record["lanes"].items()
        for name, one in own.items()
    ]
    peer = record["heyoka"]
    ours, theirs = (peer["best"][code]["seconds"] for code in ("geomint", "heyoka"))
    return {
        "ensemble_table": _table(heads, rows),
        "ensemble_overhead": " to ".join(
            f"{x:.1f}" for x in sorted(record["overhead_us"].values())
        ),
        "ensemble_heyoka": (
            f"{peer['members']} random states of the Hamiltonised sphere, n = 3, to τ = "
            f"{peer['end']:.0f}, on both cores, errors of {peer['error']:.0e} in 95 of 100: "
            f"{ours:.2f} s, and {theirs:.2f} s by heyoka's ensembles: {peer['ratio']:.2f} of that."
        ),
        "ensemble_machine": measured_on(record),
        "chart_members": str(chart["members"]),
        "chart_seconds": f"{chart['seconds']:.0f}",
        "ensemble_store": _store_words(),
    }


def _store_words() -> str:
    """Return what ensembles on disk cost beside those in memory."""
    record = result("ensemble_store")
    told = {case: record[case] for case in ("readings", "states")}
    many, states = told.values()
    disk, memory = states["disk"], states["memory"]
    return (
        f"{many['disk']['members']} members of which three readings are kept, to t = 5: "
        f"{many['disk']['seconds']:.0f} s, and {many['memory']['seconds']:.0f} s in memory; the peak "
        f"of memory grows by {many['disk']['grown_mb']:.0f} MB. {disk['members']} members "
        f"with 4001 states each: {disk['seconds']:.0f} s and {disk['grown_mb']:.0f} MB; "
        f"in memory {memory['seconds']:.0f} s and {memory['grown_mb']:.0f} MB. "
        f"On: {measured_on(record)}; `python benchmarks/ensemble_store.py`."
    )


def brouwer_words() -> dict[str, str]:
    """Return the exponents by which rounding errors grow, and what is told beside them."""
    record = result("brouwer")
    methods = record["methods"]
    keys = ("energy", "K", "norm", "tangency", "phase")
    heads = ["method", "step", "error", "H", "K", "\\|γ\\| = 1", "(γ, p̃) = 0", "phase"]
    rows = []
    for name, found in methods.items():
        time = {"t": "t", "tau": "τ"}[found["time"]]
        place = [f"`{name}`: {found['family']}", f"{found['step']:g} in {time}"]
        for part, words in (("all", "all"), ("random", "random")):
            cells = [_exponent(found["quantities"][key], part) for key in keys]
            rows.append([*place, words, *cells])
            place = ["", ""]
    steps = methods["gauss-8"]["steps"]
    digits = record["digits"]
    spans = {
        key: [b for found in methods.values() for b in _randomly(found, names)]
        for key, names in (("walk", keys[:-1]), ("phase", keys[-1:]))
    }
    left = record["seeds"][-1] + 1 - record["members"]
    return {
        "brouwer_table": _table(heads, rows),
        "brouwer_members": str(record["members"]),
        "brouwer_twins": str(record["twins"]),
        "brouwer_steps": f"10{_raised(round(math.log10(steps[-1])))}",
        "brouwer_seeds": f"0 to {record['seeds'][-1]}, of which {left} are left out",
        "brouwer_minutes": f"{sum(found['seconds'] for found in methods.values()) / 60.0:.0f}",
        "brouwer_machine": measured_on(record),
        "brouwer_moved": f"{digits['moved']} of {digits['coefficients']}",
        "brouwer_nearest": f"{digits['nearest']:.0e}",
        "brouwer_chosen": f"{digits['chosen']:.0e}",
        **{
            f"brouwer_{key}_span": f"{min(span):.2f} to {max(span):.2f}"
            for key, span in spans.items()
        },
        "brouwer_chance": f"{record['members'] ** -0.5:.2f}",
        "brouwer_gauss_mean": f"{abs(_common_part(methods['gauss-8'])):.2f}",
        "brouwer_verlet_mean": f"{abs(_common_part(methods['verlet-8'])):.2f}",
        "brouwer_common": f"{_common(methods['verlet-8']):.0e}".replace("-", "−"),
        **{
            f"brouwer_{key}": f"{methods[name]['quantities'][quantity][part]['rms'][-1]:.0e}"
            for key, (name, quantity, part) in BROUWER_SIZES.items()
        },
    }


BROUWER_SIZES = {  # what is told of rms errors at the end
    "explicit": ("dop853", "energy", "all"),
    "explicit_random": ("dop853", "energy", "random"),
    "digits": ("dop853-digits", "energy", "all"),
    "gauss": ("gauss-8", "energy", "all"),
    "gauss_phase": ("gauss-8", "phase", "all"),
    "rattle": ("rattle-2", "energy", "all"),
    "rattle_random": ("rattle-2", "energy", "random"),
    "free": ("cf-4", "energy", "all"),
    "free_random": ("cf-4", "energy", "random"),
}


def _randomly(method: dict[str, Any], names: tuple[str, ...]) -> list[float]:
    """Return the exponents of random parts, of what does not stay within the rounding of a state."""
    found = (method["quantities"][key] for key in names)
    return [q["random"]["exponent"] for q in found if max(q["all"]["rms"]) > 2.0**-51]


def _common(method: dict[str, Any]) -> float:
    """Return the mean over members of the error of the energy at the end."""
    return _common_part(method) * float(method["quantities"]["energy"]["all"]["rms"][-1])


def _common_part(method: dict[str, Any]) -> float:
    """Return the same over the rms."""
    return float(method["quantities"]["energy"]["common part"][-1])


def _exponent(found: dict[str, Any], part: str) -> str:
    """Return an exponent with its error; "–" for the random part of what is met in every step."""
    own = found[part]
    if part == "random" and max(found["all"]["rms"]) < 2.0**-51:
        return "–"
    b = round(own["exponent"], 2) + 0.0  # not −0
    return f"{b:.2f} ± {max(own['error'], 0.01):.2f}"


def _raised(number: int) -> str:
    return str(number).translate(str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹"))


def symplectic_words() -> dict[str, str]:
    """Return what methods do to symplectic forms."""
    record = result("symplecticity")
    problems = record["table"]
    rows = []
    for name, fraction in record["fractions"].items():
        cells = []
        for of_problem in problems.values():
            row = of_problem.get(name)
            if row is None:
                cells.append("–")
            elif row["rounding"] == row["runs"]:
                cells.append("rounding")
            else:
                order = "" if row["order"] is None else f" ({row['order']:.1f})"
                cells.append(f"{row['mean']:.0e}{order}")
        rows.append([f"`{name}`, {fraction} T", *cells])
    states = max(row["runs"] for one in problems.values() for row in one.values())
    wrong = record["not within rounding"]
    return {
        "symplectic_table": _table(["method, step", *problems], rows),
        "symplectic_states": str(states),
        "symplectic_runs": str(record["symplectic runs"]),
        "symplectic_wrong": str(wrong) if wrong else "none",
    }


def largest_step_words() -> dict[str, str]:
    """Return the longest steps whose stages are found, by fixed point and by Newton's method."""
    record = result("largest_step")
    rows = []
    for name, found in record["cases"].items():
        before, factor, took = found["before"], found["factor"], found["seconds"]
        more = f"{record['most']:.0f} or more" if factor >= record["most"] else f"{factor:.1f}"
        after = f"{before * factor:.3g}"
        title = f"`{name}`" if " " not in name else name
        costs = [f"{1e6 * s:.2g}" if s else "–" for s in took.values()]
        costs = [str(int(float(c))) if c != "–" and float(c) >= 10.0 else c for c in costs]
        rows.append([title, str(found["rows"]), f"{before:.3g}", after, more, *costs])
    head = [
        "",
        "numbers",
        "fixed point",
        "with Newton",
        "times",
        "µs at ½",
        "at 1½",
        "at 3",
        "at 5",
    ]
    factors = [found["factor"] for found in record["cases"].values()]
    return {
        "largest_step_table": _table(head, rows),
        "largest_step_cases": str(len(factors)),
        "largest_step_five": str(sum(factor >= 5.0 for factor in factors)),
        "largest_step_machine": measured_on(record),
    }


WORDS = {bool: "true or false", int: "whole number", float: "number", str: "string"}


def _kind(field: FieldInfo) -> str:
    """Return in words what a key takes, and what it is if it is not given."""
    words = list(dict.fromkeys(_words(field.annotation)))
    text = " or ".join(words)
    if field.is_required():
        return f"{text}, required"
    if field.default is None:
        return text
    return f"{text}, default {json.dumps(field.default)}"


def _words(annotation: Any) -> list[str]:
    """Return the alternatives of a type."""
    if typing.get_origin(annotation) in (typing.Union, types.UnionType):
        return [word for part in typing.get_args(annotation) for word in _words(part)]
    if typing.get_origin(annotation) is typing.Annotated:
        return _words(typing.get_args(annotation)[0])
    if typing.get_origin(annotation) is list:
        (inner,) = _words(typing.get_args(annotation)[0])
        return ["numbers"] if inner == "number" else ["lists of numbers"]
    return [] if annotation is type(None) else [WORDS[annotation]]


def substitutions() -> dict[str, str]:
    """Return what stands for ``{{ name }}`` on the pages."""
    return {
        "benchmark": benchmark(),
        "against_peers": against_peers("geometric_mean", True),
        "against_peers_steps": against_peers("steps_alone_mean", False),
        "against_peers_clock": {
            "wall": "the clock on the wall",
            "processor": "the processor, since the machine did other things too",
        }[result("against_peers")["clock"]],
        "against_peers_states": str(result("against_peers")["states"]),
        **times_words(),
        **sections_words(),
        **error_words(),
        **tolerance_words(),
        **traps_words(),
        **frequency_words(),
        **uneven_words(),
        **another_time_words(),
        **lyapunov_words(),
        **ensemble_words(),
        **brouwer_words(),
        **symplectic_words(),
        "against_peers_machine": measured_on(result("against_peers")),
        **largest_step_words(),
        "peers": peers(),
        "peers_machine": measured_on(result("peers_per_step")),
        "kernel_limits": kernel_limits(),
        "kernel_limits_machine": measured_on(result("kernel_limits")),
        "step_cost": step_cost(),
        "step_cost_machine": measured_on(result("step_cost")),
        "elementary": elementary(),
        "elementary_machine": measured_on(result("elementary")),
        "main_job": main_job(),
        "main_job_machine": measured_on(result("observer_loop")),
        "methods_ball": methods("ball"),
        "methods_sphere": methods("sphere"),
        "methods_rkmk": methods("rkmk"),
        "methods_machine": measured_on(result("method_tables")),
        "on_the_manifold": on_the_manifold(),
        "on_the_manifold_machine": measured_on(result("on_the_manifold")),
        "splittings": splittings(),
        "plan_scenes": plan_scenes(),
        "plan_rules": plan_rules(),
        "plan_machine": measured_on(result("plan_table")),
        "plan_steps": f"{result('plan_table')['steps']:,}".replace(",", " "),
        "scene_keys": scene_keys(),
        "scenes": scenes(),
        **elsewhere(),
        **drift_tables(),
    }
