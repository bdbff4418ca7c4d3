"""Hard cases: scenes over a range of the parameter that makes them hard, run by every engine and compared with exact or other solutions."""
