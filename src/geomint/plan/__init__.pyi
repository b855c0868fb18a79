from .chaos import ChaosPlan as ChaosPlan, plan_chaos as plan_chaos
from .choice import Choice as Choice, Route as Route, Saving as Saving
from .duration import Estimate as Estimate, estimate as estimate, expected_time as expected_time
from .fitting import representation_for as representation_for
from .plan import Plan as Plan, make_plan as make_plan, run_scene as run_scene
from .scan import ScanPlan as ScanPlan, plan_scan as plan_scan
from .sections import SectionPlan as SectionPlan, plan_section as plan_section
from .several import (
    MethodRun as MethodRun,
    SeveralRuns as SeveralRuns,
    common_notes as common_notes,
    expected_plans as expected_plans,
    run_methods as run_methods,
    run_plan as run_plan,
)
