"""Drawing of the slider crank with the loads of its joints."""
