"""What the cases of the system measure; titles, texts, questions and charts stand in the TOML file of each case."""
