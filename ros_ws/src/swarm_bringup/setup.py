"""Installs the launch files and the viewers' settings with colcon into a ROS workspace; it holds no Python package."""

from glob import glob

from setuptools import setup

NAME = "swarm_bringup"

setup(
    name=NAME,
    version="0.1.0",
    description="Launch files of the swarm",
    license="Apache-2.0",
    maintainer="Swarm founders",
    maintainer_email="founders@swarm.invalid",
    packages=[],
    py_modules=[],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/launch", sorted(glob("launch/*.launch.py"))),
        (f"share/{NAME}/config", sorted(glob("config/*"))),
    ],
    zip_safe=False,
)
