"""Component -> effect -> the test that compares it with a known answer."""

from __future__ import annotations

from cosimo.tests.contract.known_answers import here, in_file

SLIPS = ("smoothed_slip", "lugre_slip", "exact_slip")

KNOWN: dict[str, dict[str, str]] = {
    "ServoController": in_file(
        "friction_drive/test_servo_controller.py",
        quantisation="a_sleeve_between_two_counts_is_seen_at_the_lower_one",
        reference="the_set_point_follows_its_table",
    ),
    "FrictionWheels": in_file(
        "friction_drive/test_friction_wheels.py",
        **dict.fromkeys(SLIPS, "speed_under_load"),
        trocar_friction="the_seal_holds_a_small_load_and_slides_under_a_large_one",
        gravity="the_weight_slides_down_what_friction_does_not_hold",
        preload_loss="a_lost_wheel_bears_nothing_and_leaves_the_load_to_the_other",
    ),
    "FrictionDrive": {
        **in_file(
            "friction_drive/test_drive_monolith.py",
            inductance="even_wheels_with_free_rollers_are_one_motor_with_the_sleeve_on_its_shaft",
            shaft_friction="motors_that_stand_hold_the_sleeve_through_contacts_that_stick",
            # the parts it is compared with are the units with known answers of their own
            **dict.fromkeys(("trocar_friction", "gravity", "preload_loss"), "the_parts_tend_to_the_whole_with_the_step"),
        ),
        **here(**dict.fromkeys(SLIPS, "a_motor_bears_the_friction_of_its_contact_under_every_law")),
    },
}
