"""Localization on a map of the ceiling:
ros2 launch ceilmap_ros localization.launch.py rig:=/path/rig.yaml map:=/path/lab.gpkg image:=/camera/image_raw
"""

import os

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue


def generate_launch_description():
    config = os.path.join(get_package_share_directory('ceilmap_ros'), 'config', 'localization.yaml')
    arguments = [
        DeclareLaunchArgument('rig', description='rig.yaml of the robot'),
        DeclareLaunchArgument('map', default_value='', description='Map of the ceiling, NAME.gpkg'),
        DeclareLaunchArgument('params_file', default_value=config, description='Parameters of the node'),
        DeclareLaunchArgument('use_sim_time', default_value='false', description='Clock of a simulation or a bag'),
        DeclareLaunchArgument('image', default_value='ceiling/image', description='Topic of the upward camera'),
        DeclareLaunchArgument('camera_info', default_value='ceiling/camera_info', description='Its camera_info'),
        DeclareLaunchArgument('odom', default_value='odom', description='Odometry that also gives odom -> base_link'),
    ]
    node = Node(
        package='ceilmap_ros',
        executable='localization_node',
        name='ceilmap_localization',
        output='screen',
        parameters=[
            LaunchConfiguration('params_file'),
            {
                'rig': ParameterValue(LaunchConfiguration('rig'), value_type=str),
                'map': ParameterValue(LaunchConfiguration('map'), value_type=str),
                'use_sim_time': ParameterValue(LaunchConfiguration('use_sim_time'), value_type=bool),
            },
        ],
        remappings=[
            ('ceiling/image', LaunchConfiguration('image')),
            ('ceiling/camera_info', LaunchConfiguration('camera_info')),
            ('odom', LaunchConfiguration('odom')),
        ],
    )
    return LaunchDescription([*arguments, node])
