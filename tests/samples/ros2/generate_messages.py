#!/usr/bin/python3
"""Generates the C++ headers of ROS messages with Debian's rosidl, and CMake packages for find_package:
generate_messages.py INTERFACES STAND_INS OUTPUT

INTERFACES/PACKAGE/msg/NAME.msg, .../srv/NAME.srv: interface files. OUTPUT/include and OUTPUT/share/PACKAGE/cmake: the
results. The packages rclcpp, rclcpp_components, tf2_ros and rosidl_default_generators are those of STAND_INS.
"""

import json
import pathlib
import sys

from rosidl_adapter import convert_to_idl
from rosidl_generator_cpp import generate_cpp

TEMPLATES = '/usr/share/rosidl_generator_cpp/resource'


def generate(package: pathlib.Path, output: pathlib.Path) -> None:
    name = package.name
    idl = output / 'idl' / name
    tuples = []
    for file in sorted(package.glob('*/*.*')):
        written = convert_to_idl(package, name, file.relative_to(package), idl)
        tuples.append(f'{idl}:{written.relative_to(idl)}')
    arguments = idl / 'arguments.json'
    arguments.write_text(json.dumps({
        'package_name': name,
        'idl_tuples': tuples,
        'ros_interface_dependencies': [],
        'output_dir': str(output / 'include' / name),
        'template_dir': TEMPLATES,
        'target_dependencies': [],
    }))
    generate_cpp(str(arguments))


def write_package(name: str, include: pathlib.Path, needs: list, extra: str, output: pathlib.Path) -> None:
    """A package as ament exports it: NAME_TARGETS holds its imported target."""
    folder = output / 'share' / name / 'cmake'
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f'{name}Config.cmake').write_text(
        f'if(NOT TARGET {name}::{name})\n'
        f'  add_library({name}::{name} INTERFACE IMPORTED)\n'
        f'  target_include_directories({name}::{name} INTERFACE "{include}")\n'
        f'  target_link_libraries({name}::{name} INTERFACE {" ".join(f"{n}::{n}" for n in needs)})\n'
        f'endif()\n'
        f'set({name}_TARGETS {name}::{name})\n{extra}')


def main() -> None:
    interfaces, stand_ins, output = (pathlib.Path(argument).resolve() for argument in sys.argv[1:])
    include = output / 'include'
    runtime = 'find_package(rosidl_runtime_cpp REQUIRED)\n'
    for package in sorted(interfaces.iterdir()):
        generate(package, output)
        write_package(package.name, include, ['rosidl_runtime_cpp'], runtime, output)
    for name in ['rclcpp', 'rclcpp_components', 'tf2_ros']:
        extra = stand_ins / f'{name}.cmake'
        write_package(name, stand_ins / 'include', [], extra.read_text() if extra.exists() else '', output)
    generators = (stand_ins / 'rosidl_default_generators.cmake').read_text()
    write_package('rosidl_default_generators', include, [], generators, output)


if __name__ == '__main__':
    main()
