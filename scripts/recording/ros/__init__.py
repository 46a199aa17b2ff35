"""The ROS side of recording and playing back."""
