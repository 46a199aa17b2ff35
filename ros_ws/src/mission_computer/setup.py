"""Installs `mission_computer` with colcon into a ROS workspace, or with pip into a virtual environment."""

from setuptools import find_packages, setup

NAME = "mission_computer"

setup(
    name=NAME,
    version="0.1.0",
    description="The mission computer of the swarm",
    license="Apache-2.0",
    maintainer="Swarm founders",
    maintainer_email="founders@swarm.invalid",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed", "shape/**/*.json", "assembly/maps/*.json"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
    ],
    python_requires=">=3.11",
    install_requires=[
        "contourpy",
        "matplotlib",
        "numpy",
        "opencv-python-headless",
        "ortools",
        "pillow",
        "scipy",
        "shapely",
        "svgelements",
        "swarm_msgs_py",
    ],
    entry_points={"console_scripts": ["mission_node = mission_computer.ros.mission_node:main"]},
    zip_safe=False,
)
