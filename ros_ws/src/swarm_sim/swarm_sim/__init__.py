"""The swarm's simulated world: bodies, sensors, radio medium, firmware and metrics."""
