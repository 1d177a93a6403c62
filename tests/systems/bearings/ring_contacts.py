"""Contacts of a bearing between its rings, as statics and load zones need them."""

from cosimo.components.bearings.contacts import BallContacts, groove_contacts
from cosimo.components.bearings.geometry import BallGeometry


def ball_contacts(geometry: BallGeometry, stiffness: float, diametral_clearance: float = 0.0) -> BallContacts:
    """As `groove_contacts`, of a geometry."""
    g = geometry
    return groove_contacts(
        g.balls,
        float(stiffness),
        g.inner_conformity,
        g.outer_conformity,
        g.ball_diameter,
        g.pitch_diameter,
        g.contact_angle,
        diametral_clearance,
    )
