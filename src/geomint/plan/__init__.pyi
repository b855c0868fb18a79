from .choice import Choice as Choice, Route as Route, Saving as Saving
from .duration import Estimate as Estimate, estimate as estimate, expected_time as expected_time
from .fitting import representation_for as representation_for
from .plan import Plan as Plan, make_plan as make_plan, run_scene as run_scene
from .planned import Planned as Planned
from .several import (
    MethodRun as MethodRun,
    SeveralRuns as SeveralRuns,
    Variants as Variants,
    plan_methods as plan_methods,
    run_methods as run_methods,
    run_plan as run_plan,
)
