"""What judges and shows results: analysis, charts, reports, validation, studies, sweeps; knows no system by name."""
