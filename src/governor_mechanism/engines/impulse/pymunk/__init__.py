"""pymunk adapter: the only package that imports pymunk.

A Chipmunk step moves positions with the old velocities, then applies the forces, then solves the joints. Velocities therefore live at
half steps. If each step removes the joint errors completely and takes the loads at the pose that the step is about to reach, this is a
second-order SHAKE/Verlet scheme. With pymunk's defaults it is first order.
"""
