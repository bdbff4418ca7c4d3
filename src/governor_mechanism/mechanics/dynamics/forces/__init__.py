"""What acts on a scene: force laws, contacts and their modes, loads and other inputs."""
