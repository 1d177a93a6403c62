"""Component -> effect -> the test that compares it with a known answer."""

from __future__ import annotations

from cosimo.tests.contract.known_answers import here, in_file

KNOWN: dict[str, dict[str, str]] = {
    "JeffcottRotor": {
        **in_file(
            "rotor/test_jeffcott.py",
            unbalance="amplitude_and_phase_of_the_unbalance_response",
            internal_damping="onset_of_instability_by_internal_damping",
            orthotropy="orthotropic_supports_split_the_critical_speed_and_whirl_backwards_in_between",
            run_up="run_up_through_the_critical_speed_is_its_convolution_integral",
        ),
        "high_order": "tests/core/test_high_order.py::test_a_rotor_in_free_motion_is_the_matrix_exponential",
        **here(gravity="a_rotor_sags_by_its_weight_over_its_stiffness"),
    },
    "BeamRotor": {
        **in_file(
            "rotor/test_modal.py",
            gyroscopic="gyroscopic_splitting_of_an_overhung_disk",
            linear_supports="friswells_example_has_the_frequencies_of_an_independent_program",
        ),
        **in_file("rotor/test_elements.py", disks="disk_in_the_middle_of_a_light_shaft_is_the_jeffcott_rotor"),
        **in_file(
            "rotor/test_beam.py",
            unbalance="steady_unbalance_response_is_that_of_the_frequency_domain",
            internal_damping="internal_damping_drives_the_rotor_above_the_onset_speed",
            gravity="sag_is_that_of_beam_theory",
            run_up="a_run_up_passes_the_critical_speed_between_supports_with_damping",
            bearing_a="a_tangent_through_the_port_is_a_spring_in_the_rotor",
            bearing_b="a_tangent_through_the_port_is_a_spring_in_the_rotor",
        ),
        **in_file("rotor/test_frame_rotation.py", frame_rotation="the_steady_moment_is_polar_inertia_times_speed_times_rate"),
    },
}
