"""A line as it stands along the track: tables, layout of wires, droppers and supports, form finding."""
