"""The simulation against closed forms and against functions of the user."""
