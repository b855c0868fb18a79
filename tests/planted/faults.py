"""Faults that would harm users, one for a risk: the tests have to see each of them.

A fault is found by concept, a text within a function, never by a line. Where code moves,
`test_faults.py` lists the faults that no longer apply, and the commit that moved the code mends them.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).parents[2]


class Fault(NamedTuple):
    """`old` becomes `new` within `place` (module:function); the tests in `folder` should fail."""

    name: str
    folder: str  # of the tests, or a file of them
    place: str
    risk: str
    old: str
    new: str

    @property
    def path(self) -> Path:
        """The file of the module, seen from the root."""
        inside = Path(*self.place.partition(":")[0].split(".")).with_suffix(".py")
        return inside if (ROOT / inside).is_file() else "src" / inside

    def source(self) -> str:
        """Return the file with the fault in it; fail with a `ValueError` where it does not apply."""
        if not (ROOT / self.path).is_file() or not (ROOT / "tests" / self.folder).exists():
            raise ValueError(f"there is no {self.path}, or no {self.folder}")
        text = (ROOT / self.path).read_text("utf-8")
        node: Any = ast.parse(text)
        for part in self.place.partition(":")[2].split("."):
            node = next((n for n in ast.walk(node) if part in _names(n)), None)
            if node is None:
                raise ValueError(f"there is no {self.place}")
        lines = text.splitlines(keepends=True)
        first, last = node.lineno - 1, node.end_lineno
        inside = "".join(lines[first:last])
        if inside.count(self.old) != 1:
            raise ValueError(f"{self.place} has {self.old!r} {inside.count(self.old)} times")
        changed = "".join([*lines[:first], inside.replace(self.old, self.new), *lines[last:]])
        if ast.dump(ast.parse(changed)) == ast.dump(ast.parse(text)):
            raise ValueError(f"{self.new!r} says the same as {self.old!r}")
        return changed


def _names(node: Any) -> list[str]:
    """Return what a node defines."""
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return [node.name]
    return [getattr(target, "id", "") for target in getattr(node, "targets", [])]


def _read(text: str) -> Iterator[Fault]:
    """Yield the faults of `TEXT`: name, folder and place; the risk; the old text → the new one."""
    for fault in re.split(r"\n(?! )", text.strip()):
        head, risk, *change = fault.splitlines()
        old, new = "".join(change).split("→")
        yield Fault(*head.split(), risk.strip(), old.strip(), new.strip())


TEXT = r"""
stale-kernels kernels geomint.kernels.compiling.cache:kernel_stamp
  After an upgrade, or an edit, code compiled from the old sources runs.
  digest.update(path.read_bytes()) → pass
changed-global kernels geomint.kernels.compiling.fingerprint:Reach.holds
  A field goes on with the old value of a global that has changed.
  if space.get(name, MISSING) is not value: → if space.get(name, MISSING) is MISSING:
cache-of-others kernels geomint.kernels.compiling.private:_check
  Machine code is loaded from a folder that other users may write to.
  own &= not found.st_mode & stat.S_IWOTH and not listed and → own &= True or
helper-died kernels geomint.kernels.compiling.beside:Other._read
  A run waits a minute for a process beside it that has died.
  self._set("") → pass
other-version sending geomint.kernels.compiling.sending:_there
  A worker with another version of a module computes something else.
  or described(code).digest != digest: → or False:
atan2-slope kernels geomint.kernels.numbers.tangent:_of_atan2
  Derivatives of atan2 by its second argument have the wrong sign.
  -y / square / size → y / square / size
group-correction kernels geomint.kernels.groups.so3:so3_dexpinv
  RKMK methods on SO(3) fall back to order 2: a commutator has the wrong sign.
  turn(-0.5, c, u, v, out) → turn(0.5, c, u, v, out)
compensated-sum methods geomint.kernels.solve.compensated:add_compensated
  Roundings of steps add up: energies drift in long runs.
  z = carry[row] + increment → z = increment
stages-too-early methods geomint.kernels.solve.gauss:gauss_step
  Gauss methods take forces that depend on time at the beginning of the step.
  field(params, t + c[g] * h, → field(params, t,
newton-unproven fuzz geomint.kernels.solve.newton_endings:ended
  Newton's method takes a step for solved whose equations are not.
  return known & solved( → return solved(
momentum-off-constraint methods geomint.kernels.solve.rattle:rattle_step
  RATTLE leaves velocities that are not tangent to the constraints.
  left = project_momentum(gradients, params, t1, own, n, m) → left = still
other-branch declaring/test_declared.py geomint.kernels.solve.small_matrices:lost_rank
  Where a linkage is stretched a run takes another branch, and says success.
  and size >= PULLED * pull → and size < 0.0
tolerance-accepted methods geomint.kernels.solve.adaptive:_step
  Adaptive steps that err too much are taken all the same.
  if error <= 1.0 and not tiny: → if not tiny:
event-at-start run/test_events.py geomint.kernels.solve.events:at_start
  An event that has been handled is met again where the run begins.
  return value if abs(value) > left else 0.0 → return value
event-missed kernels/test_sign_changes.py geomint.kernels.solve.sign_changes:verdict
  Two events within one step are not seen.
  unclear or changes > 1: → unclear:
clock-of-splitting methods geomint.kernels.solve.splitting:splitting_step
  Physical time beside a splitting in τ is of first order only.
  clock(params, like(t + h, y[0]), y, scratch) → (by / half)
beyond-the-chart spaces geomint.kernels.solve.rkmk:dexpinv_series.dexpinv_inside
  A step beyond the coordinates of the group gives numbers, and no error.
  inside = extent(layout, u, work) <= 1.0 → inside = extent(layout, u, work) >= 0.0
member-cut-late ensemble geomint.kernels.solve.members:members_loop.members
  The last, shorter step of ensemble members begins at the time of the first.
  clocks[lane] = starts[k] + lengths[k] * counts[k] → clocks[lane] = starts[k]
worst-step-forgotten methods geomint.kernels.solve.ranks:_rank
  The steps that err most are not remembered, so that no warning comes.
  if number > known.largest[0]: → if number < known.largest[0]:
volume-doubled measure geomint.kernels.tangent.near_identity:log_volume
  The determinants of steps are squared: measures seem to be lost.
  return 0.5 * (log_one_plus(product) → return 1.0 * (log_one_plus(product)
derivative-without-force methods geomint.problems.evaluate:_hamiltonian_rates.hamiltonian_rates
  The derivative of a constrained motion has the constraint force with the wrong sign.
  rates[n:] -= motion.push( → rates[n:] += motion.push(
jacobian-transposed declaring/test_derivatives.py geomint.problems.derivatives:jacobian
  Jacobians are transposed.
  state, now, problem.rows, by) → state, now, problem.rows, by).T
rest-decides-step methods geomint.problems.time_scale:state_time
  A piece that is nearly at rest makes the default step far too short.
  nearly = len(times) > 1 and times[0] < RESTING * times[1] → nearly = False
repair-untold spaces geomint.problems.spaces.repair:repaired
  A state is moved onto its space without a word.
  warn(f"{said} of the state is {defect:.3g}: projected to 0", name, defect) → pass
composition-root tableaux geomint.tableaux.composition:_about_one
  Triple jumps and Suzuki's compositions do not have their orders.
  1 / Decimal(order - 1) → 1 / Decimal(order)
evaluations-miscounted methods geomint.methods.splitting:Verlet.flow
  Reports give too few evaluations, so that splittings look cheaper than they are.
  evaluations=2 * parts - 1, → evaluations=parts,
largest-forgotten watch geomint.watch.windows:Series.add
  The largest error of a run is that of its last part.
  self._max_abs = np.maximum(self._max_abs, → self._max_abs = np.maximum(0.0,
falling-trend report geomint.watch.growth:_curve
  Energies that fall linearly are not classed as linear.
  first, second = halves if halves[1] > 0.0 else -halves → first, second = halves
short-step-lost run geomint.run.solve:_integrate
  A run ends before its end, where that is no whole number of steps.
  if timeline.remainder != 0.0 and → if timeline.remainder > 1.0 and
lost-energy-untold run geomint.run.solve:solve
  A default run that has lost its energy says nothing.
  tell_lost_integrals(solution, begun, own, False, compiled) → pass
steps-kept run geomint.run.promise:Setting.kept
  Steps that err more than is promised are kept.
  return error is None or self._part(found, error) <= 1.0 → return True
estimate-too-small run geomint.run.error_estimate:finer
  Error estimates of methods of low order are up to half of the error.
  1.0 / (1.0 - 0.5**method.order) → 1.0
end-unobserved run geomint.run.recorder:Recorder.observe_end
  The last state is not observed, unless it is one of every so many.
  self._observers.add_end(self._before[0], self.reached, self._before[1]) → pass
event-told-twice run geomint.run.crossings:Crossings._has_been_told
  A run that goes on after an event meets the same event again.
  return (ahead < -near) | (again & (ahead <= near)) → return ahead < -near
draws-biased ensemble geomint.run.chains:Chains._points
  Draws on a level do not have the invariant measure.
  density = density - np.log(pivots).sum(axis=1) → density = density - 0.0
error-growth run geomint.run.accuracy.stretch:extrapolated
  Tolerances are missed where errors grow faster than time.
  if symmetric or len(t) < 4 or end <= times[-1]: → if len(t) > 0:
root-between-pieces run geomint.run.exact.roots:Roots._told
  Events of exact motions are missed where two pieces of the search meet.
  self._until = float(last[-1]), → self._until = 0.0,
exact-clock-lost chaplygin geomint.run.exact.follow:ExactRun._restart
  An exact run that goes on counts physical time from τ.
  physical = float(reached.states[0, -1]) if clock else own → physical = own
members-swapped ensemble geomint.run.ensemble.compiled:_Sweep.outcome
  Results of ensembles belong to other members where their steps differ.
  own = np.argsort(self._order) → own = self._order
files-overwritten outputs geomint.run.files.outputs:_targets
  A report replaces files that the user has changed.
  and own == digest(targets[name].read_bytes(), own): → and own:
input-overwritten cli geomint.run.files.inputs:check_no_input
  A command writes its output over its own input.
  if place.exists() and target.samefile(place): → if not place.exists():
pickle-untrusted outputs geomint.run.stored:Stored.found
  A run file from elsewhere executes what it says when it is read.
  if self.content and unpickle and self.trusted: → if self.content and unpickle:
map-unsorted report geomint.plots.scan_plot:_map
  Maps show values at other parameters than they belong to.
  z = z[order[0]][:, order[1]] → z = z[order[0]]
misspelt-keys scene geomint.scene.validate:check_content
  A misspelt key of [observe] is ignored.
  flaws += _observe_keys(tables.get("observe", {})) → pass
other-quantity plan geomint.plan.representation:_lacking
  A reduction watches a quantity that is another one there.
  same = way.same is None or name in way.same → same = True
agreement-unproven compare geomint.compare.confirmation:Confirmation.agrees
  A reference counts as confirmed by a run that contradicts it.
  self.accuracy <= POOR and self.difference <= self.accuracy + error → self.accuracy <= POOR
digits-of-slopes report geomint.reports.text:with_error
  Reports print digits that their own error makes meaningless.
  digits = min(max(power - math.floor(math.log10(error)) + 1, 1), 6) → digits = 6
wrong-is-unresolved stress geomint.stress.judge:_accuracy
  The stress test calls wrong results unresolved.
  verdict = "unresolved" if hopeless or (long and not exact) else "wrong" → verdict = "unresolved"
order-unchecked spaces geomint.testing.methods:check_method
  `geomint.testing` passes a method whose order is another one.
  sure(orders and abs(orders[-1] - method.order) < NEAR, text) → sure(orders, text)
outside-the-run methods geomint.scipy.solver:FixedStep._inside
  `geomint.scipy` evaluates functions beyond the end of the run.
  return np.clip(t, *sorted((self.begin, self.t_bound))) → return t
exit-code cli geomint.cli.options:EXIT_CODES
  Commands that fail end with code 0.
  "failed": 2 → "failed": 0
latex-specials report geomint.references.latex:_SPECIAL
  LaTeX made of titles with & does not compile.
  "{}$&#%_" → "{}$#%_"
foreign-names methods geomint.errors:offered
  A foreign package replaces a built-in method by one of the same name.
  owners = dict.fromkeys(own, "geomint") → owners: dict[str, str] = {}
warnings-dropped outputs geomint.errors:keeping.kept
  Solutions do not carry the warnings of their runs.
  vars(found)["warnings"] = tuple(told) → vars(found)["warnings"] = ()
density-sign chaplygin chaplygin.ball.classical:classical_forms.classical_log_density
  The stated invariant measure of the classical ball is not invariant.
  return -0.5 * log(weight(params, y)) → return 0.5 * log(weight(params, y))
splitting-part chaplygin chaplygin.ball.hamiltonized_splitting:splitting_parameters
  One of the flows of the splitting runs backwards.
  mu=f[at] - v → mu=v - f[at]
reaction-force chaplygin chaplygin.ball.rolling_dynamics:contact_observables.react
  The friction force lacks the radius.
  [0] * section(params, rows, "rho")[0] → [0]
path-frame chaplygin chaplygin.ball.path:_turned
  Attitudes for pictures are integrated with a commutator of the wrong sign.
  + np.cross(omega[:-1], omega[1:]) → - np.cross(omega[:-1], omega[1:])
rolled-path-order chaplygin chaplygin.ball.reconstruction:_transported
  Attitudes reconstructed along a motion lose two orders.
  quadratic / 12.0 + correction → quadratic / 12.0
rubber-inertia chaplygin chaplygin.rubber.sphere:RubberSphere.__init__
  A rubber ball with principal moments rolls without the inertia of its mass.
  total = GeneralInertia(inertia.diagonal + scale) → total = GeneralInertia(inertia.diagonal)
veselova-gradients chaplygin chaplygin.veselova.hamiltonized:geodesic_gradients
  RATTLE moves the Hamiltonised Veselova body by another Hamiltonian.
  dq[i] = -d2 * ( → dq[i] = d2 * (
veselova-generator chaplygin chaplygin.veselova.reduced:veselova_generator
  Group methods turn the Veselova body the other way.
  out[pair] = r * (aq * z - x * other) → out[pair] = r * (x * other - aq * z)
veselova-multiplier chaplygin chaplygin.veselova.lr:lr_forms.react
  The multipliers of the Veselova constraint are wrong.
  left[i] -= torque[i] → left[i] += torque[i]
ellipsoid-force chaplygin chaplygin.related.ellipsoid:ellipsoid_field
  Geodesics leave the ellipsoid: the normal force has the wrong sign.
  - lam * bx → + lam * bx
clebsch-force chaplygin chaplygin.related.clebsch:clebsch_problem
  A coefficient of the Clebsch system has the wrong sign.
  wx + wy / (values[i] * values[j]) → wx - wy / (values[i] * values[j])
neumann-integral chaplygin chaplygin.related.clebsch:neumann_integral.neumann_coefficient
  An integral of Neumann's system is not conserved.
  total += sigma * d[i] → total -= sigma * d[i]
separation-integral chaplygin chaplygin.integrable:separation_integral.separation_coefficient
  An integral of the sphere is not conserved.
  total -= pp * dgg → total += pp * dgg
clock-offset chaplygin chaplygin.exact.clock:packed_clock
  Physical time of exact motions is shifted.
  offset = -float( → offset = float(
period-digits chaplygin chaplygin.exact.periods:_points
  Frequencies near separatrices lose digits.
  power = 2 ** math.ceil(math.log2(needed)) → power = 2 ** (math.ceil(math.log2(needed)) - 2)
axes-order chaplygin chaplygin.inertia:SpecialInertia.moments
  Principal moments are given in the wrong order of axes.
  return _three(self.diagonal)[::-1].copy() → return _three(self.diagonal).copy()
other-time chaplygin chaplygin.correspondence.maps:veselova_time
  Geodesics correspond to the Veselova motion in another time.
  return 1.0 / (total * sqrt(total)) → return 1.0 / total
separated-momenta chaplygin chaplygin.spheroconical:Spheroconical.point
  Spheroconical momenta are twice as large.
  mu = 0.5 * np.sum( → mu = np.sum(
almost-poisson chaplygin chaplygin.controls:almost_poisson_tensor
  The almost Poisson tensor has the gyroscopic term with the wrong sign.
  - D * _wedge( → + D * _wedge(
spatial-frame chaplygin chaplygin.systems.models:spatial_momentum
  The momentum in space is computed in the wrong frame where an attitude is given.
  attitude @ skew_matrix(k, n) @ attitude.T → attitude.T @ skew_matrix(k, n) @ attitude
contact-picture chaplygin chaplygin.pictures.motion:draw_contact_point
  The picture of the contact point has the drift in it that its title takes out.
  path.contact(times) - np.outer(times, path.drift) → path.contact(times)
edge-cases stress chaplygin.stress.parameters:near_the_edge
  Stress cases do not come near the edge a_i a_j = D.
  a[1] = D * (1.0 - distance) / a[0] → a[1] = 0.5 * D / a[0]
audit-passes chaplygin tests.paper.claim:_verdict
  The audit calls a statement true that fails off the manifold it claims.
  if off <= HOLDS or not claim.everywhere: → if off >= 0.0:
"""
FAULTS = {fault.name: fault for fault in _read(TEXT)}
