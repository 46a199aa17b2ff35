"""Installs `swarm_msgs_py` with colcon into a ROS workspace, or with pip into a virtual environment."""

from setuptools import find_packages, setup

NAME = "swarm_msgs_py"

setup(
    name=NAME,
    version="0.1.0",
    description="Shared vocabulary of the swarm",
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
    install_requires=["numpy", "scipy", "shapely", "trimesh"],
    zip_safe=False,
)
