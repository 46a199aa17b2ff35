"""Monte Carlo studies: many simulated runs, one table and one figure."""
