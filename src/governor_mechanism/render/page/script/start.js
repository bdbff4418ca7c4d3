// A recorded run: the page begins at once.

startPage();
