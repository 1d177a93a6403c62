"""Rolling bearings: contact mechanics and geometry."""
