"""Assembly: who goes where (dispatch), in which order parts join (tree), and where and when boats move (guideposts)."""
