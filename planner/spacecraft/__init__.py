"""How does an agile spacecraft with control moment gyros image the Earth?"""
