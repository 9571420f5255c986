"""What there is to see of a plan."""

from planner.view.view import PlanView, view_plan

__all__ = ["PlanView", "view_plan"]
