"""Coverage of a solid by robots that grow outward from a leader (3D coverage paper)."""
