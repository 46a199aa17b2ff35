"""Installs `swarm_agent` with colcon into a ROS workspace, or with pip into a virtual environment."""

from setuptools import find_packages, setup

NAME = "swarm_agent"

setup(
    name=NAME,
    version="0.1.0",
    description="One robot of the swarm",
    license="Apache-2.0",
    maintainer="Swarm founders",
    maintainer_email="founders@swarm.invalid",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
    ],
    python_requires=">=3.11",
    install_requires=["numpy", "scipy", "shapely", "swarm_msgs_py"],
    entry_points={"console_scripts": ["agent_node = swarm_agent.ros.agent_node:main"]},
    zip_safe=False,
)
