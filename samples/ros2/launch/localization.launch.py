"""Localization on a map of the ceiling:
ros2 launch ceilmap_ros localization.launch.py rig:=/path/rig.yaml map:=/path/lab.gpkg image:=/camera/image_raw
"""

import os

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def start(context):
    def value(name):
        return LaunchConfiguration(name).perform(context)

    # What is not given here is as in params_file.
    given = {name: value(name) for name in ('rig', 'map') if value(name)}
    given['use_sim_time'] = value('use_sim_time').lower() == 'true'
    return [Node(
        package='ceilmap_ros',
        executable='localization_node',
        name='ceilmap_localization',
        output='screen',
        parameters=[value('params_file'), given],
        remappings=[
            ('ceiling/image', value('image')),
            ('ceiling/camera_info', value('camera_info')),
            ('odom', value('odom')),
        ],
    )]


def generate_launch_description():
    config = os.path.join(get_package_share_directory('ceilmap_ros'), 'config', 'localization.yaml')
    return LaunchDescription([
        DeclareLaunchArgument('rig', default_value='', description='rig.yaml of the robot'),
        DeclareLaunchArgument('map', default_value='', description='Map of the ceiling, NAME.gpkg'),
        DeclareLaunchArgument('params_file', default_value=config, description='Parameters of the node'),
        DeclareLaunchArgument('use_sim_time', default_value='false', description='Clock of a simulation or a bag'),
        DeclareLaunchArgument('image', default_value='ceiling/image', description='Topic of the upward camera'),
        DeclareLaunchArgument('camera_info', default_value='ceiling/camera_info', description='Its camera_info'),
        DeclareLaunchArgument('odom', default_value='odom', description='Odometry of the node that publishes it to TF'),
        OpaqueFunction(function=start),
    ])
