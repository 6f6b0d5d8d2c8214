! Laws under the names that a finite-element code gives to interfaces and materials, and the evaluation of a block of
! points in the code's own arrays. A name is LAW, LAW-STATE or LAW-STATE-ANYTHING in either case: the law's file without
! its ending, one of its initial states (BONDED, DRY), and what tells several joints of one law apart.
module quoin_joints
  use quoin
  implicit none
  private
  public :: joint_of, need_states, column, evaluate_block, start_points, refuse

  integer, parameter, public :: max_states = 32
  ! In place of a property: the law's default (an input deck cannot hold a NaN).
  real(c_double), parameter, public :: quoin_default = -9999

  type, public :: joint
    character(:), allocatable :: name
    type(quoin_law), pointer :: law => null()
    type(c_ptr) :: material = c_null_ptr
    integer :: state_count = 0
    real(c_double) :: initial(max_states) = 0
    type(quoin_stiffness_bounds) :: stiffness
    logical :: energies = .false.
  end type

  integer, parameter :: max_joints = 256, property_table = 3, property_choice = 2
  type(joint), target, save :: joints(max_joints)
  integer, save :: joint_count = 0

contains

  ! The joint of this name; made, and its properties and state variables printed, when it is asked for the first time.
  function joint_of(name, props) result(found)
    character(*), intent(in) :: name
    real(c_double), intent(in) :: props(:)
    type(joint), pointer :: found
    integer :: i
    do i = 1, joint_count
      found => joints(i)
      if (found%name == name) return
    end do
    if (joint_count == max_joints) call refuse(name, "more joints than this shim holds")
    joint_count = joint_count + 1
    found => joints(joint_count)
    found%name = name
    found%law => law_of(name)
    found%state_count = int(found%law%state_count)
    found%energies = iand(found%law%capabilities, 1_c_int64_t) /= 0
    if (found%state_count > max_states) call refuse(name, "the law has more states than this shim holds")
    call create_material(found, props)
    call find_initial_state(found)
    call print_states(found)
  end function

  subroutine need_states(points, given, more)
    type(joint), intent(in) :: points
    integer, intent(in) :: given, more
    character(100) :: reason
    if (given >= points%state_count + more) return
    write (reason, "(a, i0, a, i0)") "give it ", points%state_count + more, " state variables, not ", given
    call refuse(points%name, trim(reason))
  end subroutine

  function column(first, stride)
    real(c_double), intent(in), target :: first
    integer, intent(in) :: stride
    type(quoin_column) :: column
    column = quoin_column(c_loc(first), stride)
  end function

  ! One step. traction_old and traction_new, state_old and state_new may be the same columns. Columns of stored energy
  ! and dissipation are left out when their data are null.
  subroutine evaluate_block(points, count, normal_jump, slip, traction_old, traction_new, state_old, state_new, &
                            stored, dissipated)
    type(joint), intent(in) :: points
    integer, intent(in) :: count
    type(quoin_column), intent(in) :: normal_jump, slip(2), traction_old(3), traction_new(3)
    type(quoin_column), intent(in), target :: state_old(max_states), state_new(max_states)
    type(quoin_column), intent(in) :: stored, dissipated(4)
    procedure(evaluate_function), pointer :: evaluate
    type(quoin_batch) :: batch
    character(120) :: reason
    batch%struct_size = c_sizeof(batch)
    batch%count = count
    batch%normal_jump = normal_jump
    batch%slip_increment = slip
    batch%traction_old = traction_old
    batch%traction_new = traction_new
    batch%state_old = c_loc(state_old)
    batch%state_new = c_loc(state_new)
    if (points%energies) then
      batch%energy_stored = stored
      batch%dissipated = dissipated
    end if
    call c_f_procpointer(points%law%evaluate, evaluate)
    if (evaluate(points%material, batch) /= 0) call refuse(points%name, "the law refuses the arrays of the block")
    if (batch%failed_count > 0) then
      write (reason, "(i0, a)") batch%failed_count, " points have displacements or states that are not finite; is the " // &
        "time increment stable?"
      call refuse(points%name, trim(reason))
    end if
  end subroutine

  ! Points that the code has never passed before (the variable behind the states is 0) get the initial state.
  subroutine start_points(points, count, started, stride, states)
    type(joint), intent(in) :: points
    integer, intent(in) :: count, stride
    real(c_double), intent(inout) :: started(stride, *)
    type(quoin_column), intent(in) :: states(max_states)
    real(c_double), pointer :: values(:)
    integer :: i, k
    do i = 1, count
      if (started(1, i) > 0.5) cycle
      started(1, i) = 1
      do k = 1, points%state_count
        call c_f_pointer(states(k)%data, values, [1 + states(k)%stride * (count - 1)])
        values(1 + states(k)%stride * (i - 1)) = points%initial(k)
      end do
    end do
  end subroutine

  function law_of(name) result(law)
    character(*), intent(in) :: name
    type(quoin_law), pointer :: law
    character(4000) :: folders
    character(:), allocatable :: file, reason, reasons
    integer :: start, length
    file = word(name, 1) // ".so"
    call get_environment_variable("QUOIN_LAW_PATH", folders)
    reasons = ""
    start = 1
    do while (start <= len_trim(folders))
      length = index(folders(start:len_trim(folders)) // ":", ":") - 1
      law => open_law(folders(start:start + length - 1) // "/" // file, reason)
      if (associated(law)) return
      reasons = reasons // new_line("a") // reason
      start = start + length + 1
    end do
    call refuse(name, "no law; set QUOIN_LAW_PATH to the folder of the laws, separated by ':'" // reasons)
  end function

  ! Numbers and choices (by index) in the law's order; properties behind the last given one have their defaults.
  subroutine create_material(points, props)
    type(joint), intent(inout) :: points
    real(c_double), intent(in) :: props(:)
    procedure(create_material_function), pointer :: create
    procedure(stiffness_bounds_function), pointer :: stiffness_bounds
    type(c_ptr), pointer :: infos(:), choices(:)
    type(quoin_property_info), pointer :: info
    real(c_double), target :: numbers(size(props))
    type(quoin_property_value), target :: values(size(props))
    type(c_ptr) :: pointers(size(props))
    character(kind=c_char, len=4000), target :: message
    type(quoin_text) :: text
    real(c_double) :: value
    integer :: i, property, given
    print "(5a)", "quoin: ", points%name, ": law ", fortran_text(points%law%id), ", properties in the order of the deck:"
    call c_f_pointer(points%law%properties, infos, [points%law%property_count])
    property = 0
    given = 0
    do i = 1, size(infos)
      call c_f_pointer(infos(i), info)
      if (info%kind == property_table) cycle
      property = property + 1
      value = quoin_default
      if (property <= size(props)) value = props(property)
      if (abs(value - quoin_default) < 0.5) then
        print "(a, i4, 4a)", "quoin: ", property, " ", fortran_text(info%id), " default ", fortran_text(info%unit)
        cycle
      end if
      print "(a, i4, 3a, es14.7, 2a)", "quoin: ", property, " ", fortran_text(info%id), " ", value, " ", &
        fortran_text(info%unit)
      given = given + 1
      values(given)%id = info%id
      pointers(given) = c_loc(values(given))
      if (info%kind == property_choice) then
        if (nint(value) < 0 .or. nint(value) >= info%choice_count) &
          call refuse(points%name, fortran_text(info%id) // " is a choice: give its index, from 0")
        call c_f_pointer(info%choices, choices, [info%choice_count])
        values(given)%text = choices(nint(value) + 1)
      else
        numbers(given) = value
        values(given)%number_count = 1
        values(given)%numbers = c_loc(numbers(given))
      end if
    end do
    if (size(props) > property) call refuse(points%name, "more properties than the law has")
    text%data = c_loc(message)
    text%capacity = len(message)
    call c_f_procpointer(points%law%create_material, create)
    if (create(points%law, int(given, c_int64_t), pointers, points%material, text) /= 0) &
      call refuse(points%name, message(1:min(int(text%length), len(message))))
    call c_f_procpointer(points%law%stiffness_bounds, stiffness_bounds)
    if (stiffness_bounds(points%material, points%stiffness) /= 0) call refuse(points%name, "no stiffness bounds")
  end subroutine

  subroutine find_initial_state(points)
    type(joint), intent(inout) :: points
    procedure(initial_state_function), pointer :: initial_state
    type(c_ptr), pointer :: ids(:)
    type(c_ptr) :: chosen
    character(:), allocatable :: asked, known
    integer :: i
    call c_f_pointer(points%law%initial_states, ids, [points%law%initial_state_count])
    asked = word(points%name, 2)
    chosen = c_null_ptr
    if (asked == "") chosen = ids(1)
    known = ""
    do i = 1, size(ids)
      if (asked == fortran_text(ids(i))) chosen = ids(i)
      known = known // " " // fortran_text(ids(i))
    end do
    if (.not. c_associated(chosen)) &
      call refuse(points%name, "no initial state " // asked // "; the law has" // known // ". Names are LAW-STATE-ANYTHING")
    call c_f_procpointer(points%law%initial_state, initial_state)
    if (initial_state(points%material, chosen, points%initial) /= 0) call refuse(points%name, "no initial state")
  end subroutine

  subroutine print_states(points)
    type(joint), intent(in) :: points
    type(c_ptr), pointer :: infos(:)
    type(quoin_state_info), pointer :: info
    integer :: i
    call c_f_pointer(points%law%states, infos, [points%law%state_count])
    do i = 1, points%state_count
      call c_f_pointer(infos(i), info)
      print "(a, i4, 4a)", "quoin: state variable ", i, " ", fortran_text(info%id), " ", fortran_text(info%unit)
      if (info%kind /= 1) call refuse(points%name, "a state is a vector, which the code does not turn with the surface")
    end do
  end subroutine

  function word(name, which)  ! of a name, in lower case; empty behind the last
    character(*), intent(in) :: name
    integer, intent(in) :: which
    character(:), allocatable :: word
    integer :: start, length, i
    start = 1
    do i = 1, which
      length = index(name(start:) // "-", "-") - 1
      word = trim(name(start:start + length - 1))
      start = min(start + length + 1, len(name) + 1)
    end do
    do i = 1, len(word)
      if (word(i:i) >= "A" .and. word(i:i) <= "Z") word(i:i) = achar(iachar(word(i:i)) + 32)
    end do
  end function

  subroutine refuse(name, reason)
    character(*), intent(in) :: name, reason
    print "(4a)", "quoin: ", name, ": ", reason
    error stop 1
  end subroutine

end module
