"""A scene in the hand: opened once, and stepped, asked and set from outside."""
