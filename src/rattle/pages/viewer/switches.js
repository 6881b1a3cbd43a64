export function takeSides() {}
export function endOnSwitch() { return true; }
export function turnSwitch() {}
