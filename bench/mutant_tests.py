"""Which tests look at which file, for `mutants.py`."""

# The tests of a file by the beginning of its path, likeliest and quickest first; the longest
# beginning counts.  Files in tests/ without their .py, one of their tests after `::`.
FIRST = {
    "planner/verification/": "oracles/test_verification_pointing oracles/test_verification_limits "
    "oracles/test_verification_structure oracles/test_verification_sky "
    "published/test_verification_golden",
    "planner/verification/air.py": "oracles/test_verification_refraction",
    "planner/verification/bench_motion.py": "oracles/test_verification_bench_motion",
    "planner/verification/carrier.py": "properties/test_verification_pieces "
    "oracles/test_verification_pointing published/test_verification_golden",
    "planner/verification/clock.py": "properties/test_verification_pieces "
    "oracles/test_verification_structure oracles/test_verification_pointing",
    "planner/verification/earth.py": "properties/test_verification_pieces "
    "oracles/test_verification_pointing",
    "planner/verification/earth_fixed.py": "oracles/test_verification_pointing "
    "properties/test_verification_pieces oracles/test_verification_refraction",
    "planner/verification/hermite.py": "oracles/test_verification_limits "
    "properties/test_verification_pieces",
    "planner/verification/judge.py": "oracles/test_verification_bench_motion "
    "oracles/test_verification_structure oracles/test_verification_sky "
    "oracles/test_verification_pointing",
    "planner/verification/keep_out.py": "end_to_end/test_keep_out_plans",
    "planner/verification/field_masks.py": "oracles/test_spherical_polygon "
    "end_to_end/test_field_masks",
    "planner/verification/light.py": "properties/test_verification_pieces "
    "properties/test_verification_sky_pieces oracles/test_verification_pointing",
    "planner/verification/limb.py": "oracles/test_verification_sky "
    "properties/test_verification_sky_pieces oracles/test_verification_refraction",
    "planner/verification/limits.py": "oracles/test_verification_limits "
    "properties/test_verification_pieces",
    "planner/verification/pointing.py": "oracles/test_verification_pointing "
    "oracles/test_verification_sky oracles/test_keyhole",
    "planner/verification/sky.py": "oracles/test_verification_sky "
    "properties/test_verification_sky_pieces oracles/test_verification_refraction",
    "planner/verification/solar_system.py": "oracles/test_verification_sky "
    "properties/test_verification_sky_pieces",
    "planner/verification/stars.py": "oracles/test_verification_sky "
    "properties/test_verification_sky_pieces",
    "planner/verification/structure.py": "oracles/test_verification_structure "
    "oracles/test_verification_bench_motion",
    "planner/spacecraft/verification.py": "end_to_end/test_spacecraft_plan",
    "planner/slew/": "contracts/test_slew_methods oracles/test_slew_profiles "
    "published/test_paper_spline properties/test_slew_near_rate_limit::test_found_at_either_end "
    "properties/test_slew_near_rate_limit::"
    "test_what_cannot_be_braked_is_refused_before_anything_else "
    "properties/test_slew_near_rate_limit::"
    "test_a_refused_slew_says_which_of_its_ends_can_not_be_braked "
    "properties/test_slew_near_rate_limit::test_braking_on_rows_is_what_stepping_it_shows "
    "properties/test_slew_near_rate_limit::test_a_stop_forbids_what_meets_it_braked_hardest "
    "properties/test_slew_join oracles/test_vibration oracles/test_schedule_slew_time "
    "properties/test_slews::test_an_axis_that_takes_hours_takes_its_least_time_and_no_less "
    "properties/test_slews::test_with_hours_to_spare_an_axis_rests_where_it_began "
    "properties/test_slews::test_a_slew_proven_to_exist_is_made_although_the_solver_fails "
    "properties/test_slews::test_too_short_a_time_is_refused_and_the_named_time_works "
    "properties/test_slews::test_rows_carry_a_short_slew_whose_jerk_changes_much_from_row_to_row "
    "properties/test_slews::test_rows_carry_the_slew_within_limits_and_to_a_tenth_of_an_arcsecond "
    "properties/test_slew_near_rate_limit::test_where_rows_are_too_few_one_more_is_enough "
    "oracles/test_slew_optimum properties/test_slew_bound",
    "planner/slew/ocp.py": "properties/test_slews_by_ipopt oracles/test_slew_optimum "
    "properties/test_slew_bound oracles/test_vibration",
    "planner/slew/spans.py": "oracles/test_slew_optimum properties/test_slew_bound "
    "properties/test_slews::test_rows_carry_a_short_slew_whose_jerk_changes_much_from_row_to_row",
    "planner/slew/lower_bound.py": "properties/test_slew_bound oracles/test_slew_optimum",
    "planner/slew/vibration.py": "oracles/test_vibration properties/test_keep_out_slews",
    "app/jobs/": "contracts/test_jobs contracts/test_disposable_child",
    "app/jobs/child.py": "contracts/test_disposable_child",
    "app/jobs/dask_": "contracts/test_cluster",
    "app/jobs/disposable.py": "contracts/test_disposable_child contracts/test_jobs",
    "app/jobs/kinds.py": "contracts/test_campaign_jobs contracts/test_http_jobs",
    "app/jobs/settling.py": "contracts/test_jobs contracts/test_campaign_jobs",
    "app/requests/": "contracts/test_text_bounds contracts/test_spacecraft_requests "
    "contracts/test_horizon_request contracts/test_limits contracts/test_leap_second_requests "
    "contracts/test_number_ranges contracts/test_http_refusals",
    "app/requests/horizon": "contracts/test_horizon_request contracts/test_number_ranges "
    "contracts/test_http_horizon",
}
# With --again all of its room, and these.
THEN = {
    "planner/verification/": "oracles/test_keyhole end_to_end/test_every_target",
    "planner/spacecraft/verification.py": "contracts/test_http_spacecraft",
    "planner/slew/": "properties/test_slew_near_rate_limit properties/test_slews "
    "end_to_end/test_effort end_to_end/test_planning",
    "app/jobs/": "contracts/test_http_in_child contracts/test_stopping end_to_end/test_crashes",
    "app/requests/": "contracts/test_keep_out_request contracts/test_http_openapi "
    "contracts/test_http_plans contracts/test_http_opportunities contracts/test_http_spacecraft "
    "end_to_end/test_campaign_command contracts/test_generated_requests",
}


def tests_of(file: str) -> list[str]:
    """What pytest calls the tests of a file."""
    return _named(FIRST[max((start for start in FIRST if file.startswith(start)), key=len)])


def tests_of_room(file: str) -> list[str]:
    """Those of the file, those of its room's other files, and those of `THEN`."""
    room = next(start for start in THEN if file.startswith(start))
    of_room = [names for start, names in FIRST.items() if start.startswith(room)]
    return list(dict.fromkeys([*tests_of(file), *_named(" ".join([*of_room, THEN[room]]))]))


def _named(names: str) -> list[str]:
    parts = [name.partition("::") for name in names.split()]
    return [f"tests/{path}.py{colons}{test}" for path, colons, test in parts]
