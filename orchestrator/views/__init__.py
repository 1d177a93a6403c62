"""Results and scenes as users look at them: in a notebook, as data of other libraries, as drawings, all without Plotly."""
