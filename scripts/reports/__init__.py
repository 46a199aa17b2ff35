"""What a person looks at after a run: the report page and figures, made from the run folder alone."""
