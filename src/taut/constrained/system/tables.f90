!> What only tables need of a system: names of columns, further columns, quantities, texts, and events that are recorded.
module taut_constrained_system_tables
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use taut_kinds, only: wp
   use taut_error, only: to_text
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_constrained_system_reducible, only: reducible_system_t
   implicit none (type, external)
   private
   public :: tabulated_system_t, magnitude_t, quantity_t, name_length, coordinate_name, velocity_name

   !> Length of the names of coordinates, velocities, outputs and events, padded with blanks: results of deferred length would be
   !! kept in static memory, which threads share.
   integer, parameter :: name_length = 128

   !> A number that a system knows about itself, for tables and drawings.
   type :: quantity_t
      !> Without commas and blanks.
      character(:), allocatable :: name
      !> Its value.
      real(wp) :: value = 0.0_wp
      !> Its unit, without commas; `1` if it has none.
      character(:), allocatable :: unit
   end type quantity_t

   !> The size of a vector whose components along unit vectors at right angles are multipliers: a summary tells its largest value.
   type :: magnitude_t
      !> Without commas and blanks.
      character(len=name_length) :: name
      !> Which multipliers lambda.
      integer, allocatable :: rows(:)
   end type magnitude_t

   !> A system with something to say in tables. Everything has a default, so that any system can be one.
   type, abstract, extends(reducible_system_t) :: tabulated_system_t
      !> Numbers that the system computes at a state besides the standard ones.
      integer :: n_outputs = 0
      !> Functions of the state whose sign changes are events.
      integer :: n_events = 0
      !> Of each of them: 1 for sign changes upward, -1 downward, 0 both; not allocated: both. Whether an integration stops there;
      !! not allocated: nowhere. (n_events)
      integer, allocatable :: event_direction(:)
      logical, allocatable :: event_terminal(:)
      !> Whether it is an event at the start already that a function has the sign behind one; not allocated: of none. (n_events)
      logical, allocatable :: event_from_start(:)
      !> Whether the functions depend on the multipliers: then `reaction_event_values` gives them.
      logical :: events_see_reactions = .false.
   contains
      procedure :: x_name => numbered_x
      procedure :: v_name => numbered_v
      procedure :: output_name => numbered_output
      procedure :: outputs => no_outputs
      procedure :: magnitudes => no_magnitudes
      procedure :: quantities => no_quantities
      procedure :: describe => no_text
      procedure :: note => no_text
      procedure :: diagnose => nothing_to_say
      procedure :: event_name => numbered_event
      procedure :: event_values => no_event_values
      procedure :: reaction_event_values => event_values_alone
   end type tabulated_system_t

contains

   !> What a coordinate of any system is called where something is said of it.
   function coordinate_name(model, i) result(name)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Index of the coordinate.
      integer, intent(in) :: i
      !> Its name in tables, or that it is the i-th.
      character(len=name_length) :: name

      name = 'coordinate '//to_text(i)
      select type (model)
      class is (tabulated_system_t)
         name = model%x_name(i)
      end select
   end function coordinate_name

   !> What a velocity of any system is called where something is said of it.
   function velocity_name(model, i) result(name)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Index of the velocity.
      integer, intent(in) :: i
      !> Its name in tables, or that it is the i-th.
      character(len=name_length) :: name

      name = 'velocity '//to_text(i)
      select type (model)
      class is (tabulated_system_t)
         name = model%v_name(i)
      end select
   end function velocity_name

   !> Name of a coordinate in tables; the default is x1, x2, ...
   function numbered_x(self, i) result(name)
      !> The system.
      class(tabulated_system_t), intent(in) :: self
      !> Index of the coordinate.
      integer, intent(in) :: i
      !> Without commas and blanks.
      character(len=name_length) :: name

      name = 'x'//to_text(i)
      associate (unused_system => self)
      end associate
   end function numbered_x

   !> Name of a velocity in tables; the default is v1, v2, ...
   function numbered_v(self, i) result(name)
      !> The system.
      class(tabulated_system_t), intent(in) :: self
      !> Index of the velocity.
      integer, intent(in) :: i
      !> Without commas and blanks.
      character(len=name_length) :: name

      name = 'v'//to_text(i)
      associate (unused_system => self)
      end associate
   end function numbered_v

   !> Name of a further column in tables; the default is output1, output2, ...
   function numbered_output(self, i) result(name)
      !> The system.
      class(tabulated_system_t), intent(in) :: self
      !> Index of the output.
      integer, intent(in) :: i
      !> Without commas and blanks.
      character(len=name_length) :: name

      name = 'output'//to_text(i)
      associate (unused_system => self)
      end associate
   end function numbered_output

   !> What the system computes at a state for tables: forces of its parts, positions of its points; the default, for
   !! systems that announce outputs and do not compute them, is not a number.
   subroutine no_outputs(self, at, lambda, values)
      !> The system.
      class(tabulated_system_t), intent(in) :: self
      !> The state that the row of the table is about.
      type(state_t), intent(in) :: at
      !> Multipliers of Eq. (14b): (c).
      real(wp), intent(in) :: lambda(:)
      !> The numbers: (n_outputs).
      real(wp), intent(out) :: values(:)

      values(:) = ieee_value(values, ieee_quiet_nan)
      associate (unused_system => self, unused_state => at, unused_multipliers => lambda)
      end associate
   end subroutine no_outputs

   !> Vectors of which a summary tells the largest size, such as the forces of joints; the default has none.
   function no_magnitudes(self) result(list)
      !> The system.
      class(tabulated_system_t), intent(in) :: self
      !> In the order of a table.
      type(magnitude_t), allocatable :: list(:)

      allocate (list(0))
      associate (unused_system => self)
      end associate
   end function no_magnitudes

   !> What the system knows about itself, such as numbers that follow from its data; the default is nothing.
   function no_quantities(self) result(list)
      !> The system.
      class(tabulated_system_t), intent(in) :: self
      !> In the order of a table.
      type(quantity_t), allocatable :: list(:)

      allocate (list(0))
      associate (unused_system => self)
      end associate
   end function no_quantities

   !> `describe`: what people are told before a run, lines with their ends; `note`: what a reader of the results has to know, one
   !! line without commas for their summary. The default is nothing.
   subroutine no_text(self, text)
      !> The system.
      class(tabulated_system_t), intent(in) :: self
      !> The text.
      character(:), allocatable, intent(out) :: text

      text = ''
      associate (unused_system => self)
      end associate
   end subroutine no_text

   !> What a system has to say where an integration did not get on; the default is nothing.
   subroutine nothing_to_say(self, at, text)
      !> The system.
      class(tabulated_system_t), intent(in) :: self
      !> The state that was reached.
      type(state_t), intent(in) :: at
      !> What may be wrong with it, and what to do; not allocated if there is nothing to say.
      character(:), allocatable, intent(out) :: text

      if (.false.) text = ''
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine nothing_to_say

   !> Name of an event in tables; the default is event1, event2, ...
   function numbered_event(self, i) result(name)
      !> The system.
      class(tabulated_system_t), intent(in) :: self
      !> Index of the event.
      integer, intent(in) :: i
      !> Without commas and blanks.
      character(len=name_length) :: name

      name = 'event'//to_text(i)
      associate (unused_system => self)
      end associate
   end function numbered_event

   !> Functions whose sign changes are recorded; the default, for systems that announce none, never changes sign.
   subroutine no_event_values(self, at, values)
      !> The system.
      class(tabulated_system_t), intent(in) :: self
      !> The state at which they are evaluated.
      type(state_t), intent(in) :: at
      !> The functions: (n_events).
      real(wp), intent(out) :: values(:)

      values(:) = 1.0_wp
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine no_event_values

   !> The same of functions that depend on the multipliers, such as the force of a contact that ends; the default is `event_values`.
   subroutine event_values_alone(self, at, lambda, values)
      !> The system.
      class(tabulated_system_t), intent(in) :: self
      !> The state at which they are evaluated, on the constraints.
      type(state_t), intent(in) :: at
      !> Multipliers of Eq. (14b): (c).
      real(wp), intent(in) :: lambda(:)
      !> The functions: (n_events).
      real(wp), intent(out) :: values(:)

      call self%event_values(at, values)
      associate (unused_multipliers => lambda)
      end associate
   end subroutine event_values_alone

end module taut_constrained_system_tables
